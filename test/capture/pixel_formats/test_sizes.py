"""A picture takes as many bytes as its decoder reads, and not one less."""

from __future__ import annotations

from blob_tracker.capture.pixel_formats import PIXEL_FORMATS
from blob_tracker.capture.pixel_formats.sizes import _HALVES, picture_bytes
import pytest

WIDTH, HEIGHT = 24, 6
PLAIN = [name for name, each in PIXEL_FORMATS.items() if not each.compressed]


@pytest.mark.parametrize('name', PLAIN)
def test_as_many_as_are_read(name: str) -> None:
    """Of planar YUV the luma alone is read, which comes first."""
    whole = picture_bytes(name, WIDTH, HEIGHT)
    read = whole * 2 // _HALVES.get(name, 2)
    known = PIXEL_FORMATS[name]
    decoder = known.luma if known.colours is None else known.colours
    decoder(bytes(read), WIDTH, HEIGHT, 0)
    with pytest.raises(ValueError):
        decoder(bytes(read - 1), WIDTH, HEIGHT, 0)
