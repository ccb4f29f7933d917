"""
Loads the machine code that Numba made, without Numba.

It is an ELF object for x86-64, in the large code model: all that it refers to it has as a whole
64-bit address, so nothing has to lie near anything else.
"""

from __future__ import annotations

from collections.abc import Mapping
import ctypes
import mmap

import numpy as np

PAGE = mmap.PAGESIZE
# Of the ELF format, https://refspecs.linuxfoundation.org/elf/elf.pdf and its supplement for x86-64.
MAGIC = b'\x7fELF\x02\x01\x01'  # 64 bits, little-endian
RELOCATABLE, X86_64 = 1, 62
SYMBOLS, RELOCATIONS, EMPTY = 2, 4, 8  # kinds of sections
ALLOCATED, EXECUTABLE = 2, 4  # flags of sections
UNDEFINED, RESERVED, ABSOLUTE, COMMON, LARGE_COMMON = 0, 0xff00, 0xfff1, 0xfff2, 0xff02
ADDRESS, DISTANCE = 1, 24  # R_X86_64_64 and R_X86_64_PC64
SECTION = np.dtype([
    ('name', '<u4'), ('kind', '<u4'), ('flags', '<u8'), ('address', '<u8'), ('offset', '<u8'),
    ('size', '<u8'), ('link', '<u4'), ('info', '<u4'), ('align', '<u8'), ('each', '<u8'),
])
SYMBOL = np.dtype([
    ('name', '<u4'), ('info', 'u1'), ('other', 'u1'), ('section', '<u2'), ('value', '<u8'),
    ('size', '<u8'),
])
RELOCATION = np.dtype([
    ('offset', '<u8'), ('kind', '<u4'), ('symbol', '<u4'), ('added', '<i8'),
])


class MachineCodeError(Exception):
    """Machine code that cannot be loaded: its message says why."""


def load(code: bytes, known: Mapping[str, int]) -> dict[str, int]:
    """
    Place an object file in memory, for as long as the process lives.

    Parameters
    ----------
    code : bytes
        As the compiler wrote it.
    known : mapping of str to int
        Addresses of what it calls; what is not in it is looked for in the process.

    Returns
    -------
    dict of str to int
        The addresses of what it defines.

    Raises
    ------
    MachineCodeError
        Where it is no such file, or calls what is nowhere.

    """
    header = np.frombuffer(code, '<u2', 32) if len(code) >= 64 else np.zeros(32, '<u2')
    if not code.startswith(MAGIC) or (header[8], header[9]) != (RELOCATABLE, X86_64):
        raise MachineCodeError('no object file for x86-64')
    start = int.from_bytes(code[40:48], 'little')
    sections = np.frombuffer(code, SECTION, int(header[30]), start)
    table = sections[sections['kind'] == SYMBOLS][0]
    symbols = np.frombuffer(code, SYMBOL, int(table['size']) // SYMBOL.itemsize, table['offset'])
    names = _names(code, symbols, sections[table['link']])

    # What is run first, then on a page of its own what is read and written.
    runs = (sections['flags'] & EXECUTABLE) != 0
    places = np.zeros(len(sections), np.uint64)
    end = 0
    for group in (runs, ~runs):
        for index in np.flatnonzero(group & ((sections['flags'] & ALLOCATED) != 0)):
            align = max(int(sections['align'][index]), 1)
            end = -(-end // align) * align
            places[index] = end
            end += int(sections['size'][index])
        if group is runs:
            run = end = -(-end // PAGE) * PAGE
    common = np.isin(symbols['section'], (COMMON, LARGE_COMMON))
    values = symbols['value'].copy()
    for index in np.flatnonzero(common):
        align = max(int(symbols['value'][index]), 1)
        end = -(-end // align) * align
        values[index] = end
        end += int(symbols['size'][index])

    base = _mapped(max(end, 1))
    memory = np.frombuffer((ctypes.c_uint8 * end).from_address(base), np.uint8)
    for index in np.flatnonzero(((sections['flags'] & ALLOCATED) != 0)):
        one = sections[index]
        if one['kind'] != EMPTY:
            content = np.frombuffer(code, np.uint8, int(one['size']), int(one['offset']))
            memory[int(places[index]):int(places[index]) + content.size] = content
    placed = (symbols['section'] != UNDEFINED) & (symbols['section'] < RESERVED) & ~common
    values[placed] += places[symbols['section'][placed]]
    values[placed | common] += np.uint64(base)
    for index in np.flatnonzero(symbols['section'] == UNDEFINED)[1:]:
        values[index] = _found(names[index], known)

    for one in sections[sections['kind'] == RELOCATIONS]:
        if sections['flags'][one['info']] & ALLOCATED:
            _relocate(memory, base, int(places[one['info']]), values, np.frombuffer(
                code, RELOCATION, int(one['size']) // RELOCATION.itemsize, int(one['offset'])
            ))
    _protect(base, run)
    return {names[index]: int(values[index]) for index in np.flatnonzero(placed | common)}


def _names(code: bytes, symbols: np.ndarray, strings: np.void) -> list[str]:
    text = code[int(strings['offset']):int(strings['offset'] + strings['size'])]
    return [text[each:text.index(b'\0', each)].decode() for each in symbols['name'].tolist()]


def _found(name: str, known: Mapping[str, int]) -> int:
    """Return where something is that the code calls."""
    if name in known:
        return known[name]
    try:
        return ctypes.cast(getattr(ctypes.pythonapi, name), ctypes.c_void_p).value or 0
    except AttributeError:
        raise MachineCodeError(f'{name} is nowhere') from None


def _relocate(
    memory: np.ndarray, base: int, start: int, values: np.ndarray, entries: np.ndarray
) -> None:
    """Write the addresses into a section."""
    if not np.isin(entries['kind'], (ADDRESS, DISTANCE)).all():
        raise MachineCodeError('relocations of another code model')
    places = entries['offset'] + np.uint64(start)
    if places.size and int(places.max()) + 8 > memory.size:
        raise MachineCodeError('a relocation beyond the end')
    targets = values[entries['symbol']] + entries['added'].view(np.uint64)
    far = entries['kind'] == DISTANCE
    targets[far] -= places[far] + np.uint64(base)
    memory[places.astype(np.intp)[:, None] + np.arange(8)] = targets.view(np.uint8).reshape(-1, 8)


def _mapped(size: int) -> int:
    """Return memory that is never given back."""
    libc = ctypes.CDLL(None, use_errno=True)
    libc.mmap.restype = ctypes.c_void_p
    libc.mmap.argtypes = (
        ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int, ctypes.c_int, ctypes.c_int, ctypes.c_long
    )
    base = libc.mmap(
        None, size, mmap.PROT_READ | mmap.PROT_WRITE, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, -1, 0
    )
    if base in (None, ctypes.c_void_p(-1).value):
        raise MachineCodeError('no memory')
    return int(base)


def _protect(base: int, size: int) -> None:
    """Let the code be run, and no longer be written."""
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.mprotect(
        ctypes.c_void_p(base), ctypes.c_size_t(size), mmap.PROT_READ | mmap.PROT_EXEC
    ):
        raise MachineCodeError('memory that may not be run')
