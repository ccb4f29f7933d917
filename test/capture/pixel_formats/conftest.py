"""Pictures with padded lines."""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.capture.pixel_formats import PIXEL_FORMATS
import numpy as np
from numpy.typing import NDArray
import pytest

Decode = Callable[[str, NDArray[np.generic], int, int], NDArray[np.generic]]


def padded(lines: NDArray[np.generic], padding: int) -> tuple[bytes, int]:
    """Return lines with junk after each and their distance; the last has none, as drivers do."""
    flat = np.ascontiguousarray(lines).view(np.uint8).reshape(len(lines), -1)
    with_junk = np.pad(flat, ((0, 0), (0, padding)), constant_values=77)
    data = with_junk.tobytes()
    return data[:len(data) - padding], with_junk.shape[1]


@pytest.fixture(params=[0, 3, 64])
def decode(request: pytest.FixtureRequest) -> Decode:
    """Give the decoder of (name, lines, width, height), with several paddings."""
    def decoded(
        name: str, lines: NDArray[np.generic], width: int, height: int
    ) -> NDArray[np.generic]:
        data, stride = padded(lines, request.param)
        return PIXEL_FORMATS[name].luma(data, width, height, stride)
    return decoded
