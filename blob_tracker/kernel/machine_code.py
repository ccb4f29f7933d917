"""
Lays out and loads the machine code that Numba made, without Numba.

It is an ELF object for x86-64, in the large code model: all that it refers to it has as a whole
64-bit address, so nothing has to lie near anything else.
"""

from __future__ import annotations

from collections.abc import Mapping
import ctypes
from functools import cache
import mmap
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

PAGE = mmap.PAGESIZE
# Of https://refspecs.linuxfoundation.org/elf/elf.pdf, and of its supplement for x86-64.
MAGIC = b'\x7fELF\x02\x01\x01'  # 64 bits, little-endian
RELOCATABLE, X86_64 = 1, 62
SYMBOLS, RELOCATIONS, EMPTY = 2, 4, 8  # kinds of sections
ALLOCATED, EXECUTABLE = 2, 4  # flags of sections
UNDEFINED, RESERVED, LARGE_COMMON, COMMON = 0, 0xff00, 0xff02, 0xfff2  # in place of a section
ADDRESS, DISTANCE = 1, 24  # R_X86_64_64 and R_X86_64_PC64
LOCAL = 0  # binding of a symbol that other files do not see
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

Records = NDArray[Any]


class MachineCodeError(Exception):
    """Machine code that cannot be loaded: its message says why."""


class Image(NamedTuple):
    """
    An object file as it will lie in memory, wherever that is.

    Parameters
    ----------
    content : bytes
        What comes first is run. Addresses are in it as if it began at 0, those of what it calls
        as if that were at 0.
    run, size : int
        Bytes of what is run, whole pages, and of all with what is empty at first.
    places : bytes
        Where addresses are in it, uint32.
    terms : bytes
        What is to be added to each of them, uint32: 0, its own address; then the address of each
        of `calls`; then those less its own.
    calls : tuple of str
        What it calls.
    symbols : dict of str to int
        Where in it is what it defines.

    """

    content: bytes
    run: int
    size: int
    places: bytes
    terms: bytes
    calls: tuple[str, ...]
    symbols: dict[str, int]


def link(code: bytes) -> Image:
    """
    Lay an object file out.

    Parameters
    ----------
    code : bytes
        As the compiler wrote it.

    Raises
    ------
    MachineCodeError
        If it is no such file.

    """
    sections = _sections(code)
    table = sections[sections['kind'] == SYMBOLS][0]
    symbols = np.frombuffer(
        code, SYMBOL, int(table['size']) // SYMBOL.itemsize, int(table['offset'])
    )
    names = _names(code, symbols, sections[table['link']])
    places, run, end = _laid_out(sections)
    common = np.isin(symbols['section'], (COMMON, LARGE_COMMON))
    values = symbols['value'].copy()
    for index in np.flatnonzero(common):  # what is empty at first; its value is its alignment
        align = max(int(symbols['value'][index]), 1)
        values[index] = end = -(-end // align) * align
        end += int(symbols['size'][index])
    here = (symbols['section'] != UNDEFINED) & (symbols['section'] < RESERVED)
    values[here] += places[symbols['section'][here]]
    here |= common
    called = np.flatnonzero(symbols['section'] == UNDEFINED)[1:]  # the first has no name
    number = np.zeros(len(symbols), np.uint32)
    number[called] = 1 + np.arange(len(called))

    memory = np.zeros(end, np.uint8)
    placed = ((sections['flags'] & ALLOCATED) != 0) & (sections['kind'] != EMPTY)
    for one, place in zip(sections[placed], places[placed].tolist(), strict=True):
        content = np.frombuffer(code, np.uint8, int(one['size']), int(one['offset']))
        memory[place:place + content.size] = content
    found = []
    for one in sections[sections['kind'] == RELOCATIONS]:
        if sections['flags'][one['info']] & ALLOCATED:
            entries = np.frombuffer(
                code, RELOCATION, int(one['size']) // RELOCATION.itemsize, int(one['offset'])
            )
            found.append(_relocate(memory, places[one['info']], values, entries, number, here))
    written, terms = np.concatenate(found or [np.zeros((2, 0), np.uint32)], axis=1)
    return Image(
        content=memory.tobytes().rstrip(b'\0'),
        run=run,
        size=end,
        places=written.tobytes(),
        terms=terms.tobytes(),
        calls=tuple(names[index] for index in called),
        symbols={
            names[index]: int(values[index])
            for index in np.flatnonzero(here & (symbols['info'] >> 4 != LOCAL))
        },
    )


def load(image: Image, known: Mapping[str, int]) -> dict[str, int]:
    """
    Place machine code in memory, for as long as the process lives.

    Parameters
    ----------
    image : Image
        As `link` makes it.
    known : mapping of str to int
        Addresses of what it calls; what is not in it is looked for in the process.

    Returns
    -------
    dict of str to int
        The addresses of what it defines.

    Raises
    ------
    MachineCodeError
        If it calls what is nowhere.

    """
    calls = [known[name] if name in known else _exported(name) for name in image.calls]
    base = _mapped(image.size)
    ctypes.memmove(base, image.content, len(image.content))
    memory = np.frombuffer(
        memoryview((ctypes.c_uint8 * image.size).from_address(base)), np.uint8
    )
    added = np.array([base, *calls, *calls], np.uint64)
    added[1 + len(calls):] -= np.uint64(base)
    _addresses(memory)[np.frombuffer(image.places, np.uint32)] += (
        added[np.frombuffer(image.terms, np.uint32)]
    )
    _protect(base, image.run)
    return {name: base + place for name, place in image.symbols.items()}


def _sections(code: bytes) -> Records:
    """Return the table of sections."""
    if len(code) < 64 or not code.startswith(MAGIC):
        raise MachineCodeError('no object file of 64 bits')
    header = np.frombuffer(code, '<u2', 32)
    if (header[8], header[9]) != (RELOCATABLE, X86_64):
        raise MachineCodeError('no object file for x86-64')
    start, count = int.from_bytes(code[40:48], 'little'), int(header[30])
    if not count or start + count * SECTION.itemsize > len(code):
        raise MachineCodeError('no table of sections')
    found = np.frombuffer(code, SECTION, count, start)
    filled = found[found['kind'] != EMPTY]
    if SYMBOLS not in found['kind'] or (filled['offset'] + filled['size']).max() > len(code):
        raise MachineCodeError('a file that is cut')
    return found


def _laid_out(sections: Records) -> tuple[NDArray[np.uint64], int, int]:
    """Return where each section goes, and where what is run ends, and all."""
    places = np.zeros(len(sections), np.uint64)
    end = run = 0
    runs = (sections['flags'] & EXECUTABLE) != 0
    for group in (runs, ~runs):
        for index in np.flatnonzero(group & ((sections['flags'] & ALLOCATED) != 0)):
            align = max(int(sections['align'][index]), 1)
            end = -(-end // align) * align
            places[index] = end
            end += int(sections['size'][index])
        if group is runs:  # the rest is on pages of its own, which may be written
            run = end = -(-end // PAGE) * PAGE
    return places, run, end


def _names(code: bytes, symbols: Records, strings: np.void) -> list[str]:
    text = code[int(strings['offset']):int(strings['offset'] + strings['size'])]
    return [text[each:text.index(b'\0', each)].decode() for each in symbols['name'].tolist()]


@cache
def _exported(name: str) -> int:
    """Return where something is in this process."""
    try:
        return ctypes.cast(getattr(ctypes.pythonapi, name), ctypes.c_void_p).value or 0
    except AttributeError:
        raise MachineCodeError(f'{name} is nowhere') from None


def _relocate(
    memory: NDArray[np.uint8], start: np.uint64, values: NDArray[np.uint64], entries: Records,
    number: NDArray[np.uint32], here: NDArray[np.bool_],
) -> NDArray[np.uint32]:
    """Write into a section what is known of its addresses; return places and terms, as `Image`."""
    if not np.isin(entries['kind'], (ADDRESS, DISTANCE)).all():
        raise MachineCodeError('relocations of another code model')
    places = entries['offset'] + start
    if places.size and int(places.max()) + 8 > memory.size:
        raise MachineCodeError('a relocation beyond the end')
    targets = values[entries['symbol']] + entries['added'].view(np.uint64)
    far = entries['kind'] == DISTANCE
    targets[far] -= places[far]
    _addresses(memory)[places] = targets
    terms = number[entries['symbol']]
    terms[far & (terms > 0)] += number.max(initial=0)
    kept = (terms > 0) | (here[entries['symbol']] & ~far)
    return np.stack([places.astype(np.uint32)[kept], terms[kept]])


def _addresses(memory: NDArray[np.uint8]) -> NDArray[np.uint64]:
    """Return what an address at each byte of memory would be: they overlap."""
    return np.ndarray(max(memory.size - 7, 0), np.uint64, memory, strides=(1,))


def _mapped(size: int) -> int:
    """Return the address of memory that is never given back."""
    base = _libc().mmap(
        None, size, mmap.PROT_READ | mmap.PROT_WRITE, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, -1, 0
    )
    if base in (None, ctypes.c_void_p(-1).value):
        raise MachineCodeError('no memory')
    return int(base)


def _protect(base: int, size: int) -> None:
    """Let the code be run, and no longer be written."""
    if _libc().mprotect(base, size, mmap.PROT_READ | mmap.PROT_EXEC):
        raise MachineCodeError('memory that may not be run')


@cache
def _libc() -> ctypes.CDLL:
    libc = ctypes.CDLL(None)
    libc.mmap.restype = ctypes.c_void_p
    libc.mmap.argtypes = (
        ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int, ctypes.c_int, ctypes.c_int, ctypes.c_long
    )
    libc.mprotect.argtypes = (ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int)
    return libc
