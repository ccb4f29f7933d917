"""
Samples of 10, 12 and 14 bits without gaps between them: Y10P, Y12P, Y14P, Y10B and packed Bayer.

The MIPI packing of CSI-2 (RAW10, RAW12, RAW14) has the upper 8 bits of a group's samples first,
a byte each, and then their low bits side by side, the first sample's lowest. Y10B is one string
of bits, the most significant first. What a byte adds to the samples of its group is looked up,
all of them at once: shifting sample by sample takes four times as long.
"""

from __future__ import annotations

from blob_tracker.capture.pixel_formats.lines import lines
from blob_tracker.capture.pixel_formats.pixel_format import PixelData
import numpy as np
from numpy.typing import NDArray

Words = NDArray[np.unsignedinteger]


def mipi10(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint16]:
    """Return the samples of RAW10: four in five bytes."""
    return _cut(_mipi(_groups(data, width, height, stride, 4, 5), _RAW10), width)


def mipi12(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint16]:
    """Return the samples of RAW12: two in three bytes."""
    return _cut(_mipi(_groups(data, width, height, stride, 2, 3), _RAW12), width)


def mipi14(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint16]:
    """Return the samples of RAW14: four in seven bytes."""
    return _cut(_mipi(_groups(data, width, height, stride, 4, 7), _RAW14), width)


def bits10(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint16]:
    """Return the samples of Y10B: four in five bytes, the most significant bit first."""
    groups = _groups(data, width, height, stride, 4, 5)
    found = _BITS10[0][groups[..., 0]]
    for place in range(1, 5):
        found |= _BITS10[place][groups[..., place]]
    return _cut(found.view(np.uint16), width)


def _groups(
    data: PixelData, width: int, height: int, stride: int, samples: int, size: int
) -> NDArray[np.uint8]:
    """Return a (height, groups, bytes of a group) view; the last group of a line is whole."""
    count = -(-width // samples)
    return lines(data, size * count, height, stride).reshape(height, count, size)


def _mipi(groups: NDArray[np.uint8], tables: list[Words]) -> NDArray[np.uint16]:
    """Return the (height, samples of a line) of groups; `tables` belong to their last bytes."""
    count = groups.shape[2] - len(tables)
    upper = groups[..., :count].view(f'u{count}')[..., 0]  # all in one piece: one fast copy
    samples = upper.copy().view(np.uint8).astype(np.uint16)
    samples <<= 8 * len(tables) // count
    found = samples.view(tables[0].dtype)
    for place, table in enumerate(tables, count):
        found |= table[groups[..., place]]
    return samples


def _cut(samples: NDArray[np.uint16], width: int) -> NDArray[np.uint16]:
    """Leave out what fills the last group."""
    return np.ascontiguousarray(samples[:, :width])


def _table(shift: int, first: int, step: int, bits: int, samples: int) -> Words:
    """
    Return what each value of a byte adds to a group's samples, 16 bits each in one word.

    The byte stands `shift` bits up in the string of bits, whose sample k has its `bits` bits from
    bit `first + step * k` on.
    """
    string = np.arange(256, dtype=np.uint64) << np.uint64(shift)
    word = np.zeros(256, np.uint64)
    for sample in range(samples):
        part = string >> np.uint64(first + step * sample) & np.uint64((1 << bits) - 1)
        word |= part << np.uint64(16 * sample)
    return word.astype(f'u{2 * samples}')


_RAW10 = [_table(0, 0, 2, 2, 4)]
_RAW12 = [_table(0, 0, 4, 4, 2)]
_RAW14 = [_table(8 * place, 0, 6, 6, 4) for place in range(3)]
_BITS10 = [_table(8 * (4 - place), 30, -10, 10, 4) for place in range(5)]
