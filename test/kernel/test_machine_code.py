"""Machine code that cannot be used is refused before anything of it is run."""

from __future__ import annotations

import ctypes

from blob_tracker.kernel.machine_code import link, load, MachineCodeError
import numpy as np
import pytest

HEADER, SECTION, SYMBOL = 64, 64, 24
# mov eax, 42; ret
CODE = bytes([0xb8, 42, 0, 0, 0, 0xc3]).ljust(8, b'\0')
NAMES = b'\0answer\0nowhere_at_all\0'.ljust(24, b'\0')


def object_file(machine: int = 62, undefined: bool = False, relocation: int = 1) -> bytes:
    """Return an object file with a function that returns 42, and a place for its address."""
    start = HEADER + len(CODE) + len(NAMES)
    symbols = bytes(SYMBOL) + _packed(('I', 1), ('B', 18), ('B', 0), ('H', 1), ('Q', 0), ('Q', 6))
    if undefined:
        symbols += _packed(('I', 8), ('B', 18), ('B', 0), ('H', 0), ('Q', 0), ('Q', 0))
    entries = _packed(('Q', 0), ('I', relocation), ('I', 1), ('q', 0))
    sections = [
        (0, 0, 0, 0, 0, 0, 0, 0),
        (1, 6, HEADER, len(CODE), 0, 0, 16, 0),  # run
        (3, 0, HEADER + len(CODE), len(NAMES), 0, 0, 1, 0),  # names
        (2, 0, start, len(symbols), 2, 1, 8, SYMBOL),
        (8, 3, 0, 8, 0, 0, 8, 0),  # written
        (4, 0, start + len(symbols), len(entries), 3, 4, 8, 24),
    ]
    table = start + len(symbols) + len(entries)
    header = b'\x7fELF\x02\x01\x01' + bytes(9) + _packed(
        ('H', 1), ('H', machine), ('I', 1), ('Q', 0), ('Q', 0), ('Q', table), ('I', 0),
        ('H', HEADER), ('H', 0), ('H', 0), ('H', SECTION), ('H', len(sections)), ('H', 2),
    )
    rows = b''.join(
        _packed(('I', 0), ('I', kind), ('Q', flags), ('Q', 0), ('Q', offset), ('Q', size),
                ('I', link), ('I', info), ('Q', align), ('Q', each))
        for kind, flags, offset, size, link, info, align, each in sections
    )
    return header + CODE + NAMES + symbols + entries + rows


def _packed(*values: tuple[str, int]) -> bytes:
    return b''.join(np.array(value, f'<{kind}').tobytes() for kind, value in values)


def test_a_function_is_placed_and_runs() -> None:
    """The smallest there is."""
    found = load(link(object_file()), {})
    assert ctypes.CFUNCTYPE(ctypes.c_int)(found['answer'])() == 42


@pytest.mark.parametrize(
    ('code', 'reason'),
    [
        (b'', 'no object file'),
        (object_file()[:100], 'no table of sections'),
        (object_file(machine=183), 'for x86-64'),
        (object_file(undefined=True), 'nowhere_at_all is nowhere'),
        (object_file(relocation=2), 'another code model'),
    ],
)
def test_what_cannot_be_placed_is_refused(code: bytes, reason: str) -> None:
    """Another processor, a file that is cut, what calls what is not there."""
    with pytest.raises(MachineCodeError, match=reason):
        load(link(code), {})
    if 'nowhere' in reason:
        load(link(code), {'nowhere_at_all': 1})
