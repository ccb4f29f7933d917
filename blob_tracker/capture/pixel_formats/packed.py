"""
Samples of 10, 12 and 14 bits without gaps between them: Y10P, Y12P, Y14P, Y10B and packed Bayer.

The MIPI packing of CSI-2 (RAW10, RAW12, RAW14) has the upper 8 bits of a group's samples first,
a byte each, and then their low bits side by side, the first sample's lowest. Y10B is one string
of bits, the most significant first. All samples of a group are moved at once, in one long word:
sample by sample takes four times as long.
"""

from __future__ import annotations

from blob_tracker.capture.pixel_formats.lines import lines
from blob_tracker.capture.pixel_formats.pixel_format import PixelData
import numpy as np
from numpy.typing import NDArray


def mipi10(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint16]:
    """Return the samples of RAW10: four in five bytes."""
    groups = _groups(data, width, height, stride, 4, 5)
    return _mipi(groups[..., :4], groups[..., 4].astype(np.uint64), 2, width)


def mipi12(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint16]:
    """Return the samples of RAW12: two in three bytes."""
    groups = _groups(data, width, height, stride, 2, 3)
    return _mipi(groups[..., :2], groups[..., 2].astype(np.uint32), 4, width)


def mipi14(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint16]:
    """Return the samples of RAW14: four in seven bytes."""
    groups = _groups(data, width, height, stride, 4, 7)
    low = groups[..., 3:].view('<u4')[..., 0].astype(np.uint64)
    low >>= np.uint64(8)
    return _mipi(groups[..., :4], low, 6, width)


def bits10(data: PixelData, width: int, height: int, stride: int) -> NDArray[np.uint16]:
    """Return the samples of Y10B: four in five bytes, the most significant bit first."""
    groups = _groups(data, width, height, stride, 4, 5)
    string = groups[..., :4].view('>u4')[..., 0].astype(np.uint64)
    string <<= np.uint64(8)
    string |= groups[..., 4]
    _spread(string, 4, 10)
    # The first sample is the highest.
    return _cut(string.astype('>u8').view('>u2').astype(np.uint16), width)


def _groups(
    data: PixelData, width: int, height: int, stride: int, samples: int, size: int
) -> NDArray[np.uint8]:
    """Return a (height, groups, bytes of a group) view; the last group of a line is whole."""
    count = -(-width // samples)
    return lines(data, size * count, height, stride).reshape(height, count, size)


def _mipi(
    upper: NDArray[np.uint8], low: NDArray[np.unsignedinteger], bits: int, width: int
) -> NDArray[np.uint16]:
    """Return the samples of groups: their upper bytes, and below them `bits` of each in `low`."""
    count = upper.shape[2]
    together = upper.view(f'<u{count}')[..., 0]  # one copy of long words, not of bytes
    samples = together.copy().view(np.uint8).astype(np.uint16)
    samples <<= bits
    _spread(low, count, bits)
    samples |= low.view(np.uint16)
    return _cut(samples, width)


def _spread(words: NDArray[np.unsignedinteger], samples: int, bits: int) -> None:
    """Move the samples that lie side by side in a word 16 bits apart, in place."""
    word = words.dtype.type
    together = samples // 2
    while together:  # the upper half of what is still together moves up
        half = (1 << together * bits) - 1 << together * bits
        upper = words & word(sum(half << x for x in range(0, 16 * samples, 32 * together)))
        words ^= upper
        upper <<= word(together * (16 - bits))
        words |= upper
        together //= 2


def _cut(samples: NDArray[np.uint16], width: int) -> NDArray[np.uint16]:
    """Leave out what fills the last group."""
    return np.ascontiguousarray(samples[:, :width])
