"""Masks from image files, and a sentence for each that is none."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.parameters.mask import read_mask
import cv2
import numpy as np
import pytest

PIXELS = np.zeros((30, 40), np.uint8)
PIXELS[10:20, 5:25] = 255


@pytest.mark.parametrize('suffix', ['.png', '.pgm', '.bmp'])
@pytest.mark.parametrize('scheme', ['', 'file://'])
def test_white_is_where_the_target_may_be(tmp_path: Path, suffix: str, scheme: str) -> None:
    """Grey or in colour, from a path or a URL."""
    for pixels in (PIXELS, cv2.cvtColor(PIXELS, cv2.COLOR_GRAY2BGR)):
        path = tmp_path / f'mask{suffix}'
        cv2.imwrite(str(path), pixels)
        np.testing.assert_array_equal(read_mask(f'{scheme}{path}'), PIXELS == 255)


def test_no_mask_is_none() -> None:
    """The default."""
    assert read_mask('') is None


def test_what_is_no_mask_is_named(tmp_path: Path) -> None:
    """No file, a folder, no image, 16 bits, all black, another scheme."""
    text = tmp_path / 'text.png'
    text.write_text('no image')
    deep, black = tmp_path / 'deep.png', tmp_path / 'black.png'
    cv2.imwrite(str(deep), PIXELS.astype(np.uint16))
    cv2.imwrite(str(black), np.zeros_like(PIXELS))
    for url, sentence in (
        ('/no/mask.png', 'there is no file /no/mask.png'),
        ('/' + 'a' * 300, 'File name too long'),
        (str(tmp_path), 'there is no file'),
        (str(text), 'text.png is not an image'),
        (str(deep), 'deep.png has 16 bits a channel; it must have 8'),
        (str(black), 'black.png is black all over'),
        ('http://x/mask.png', 'write a path'),
    ):
        with pytest.raises(ParameterError, match=sentence):
            read_mask(url)
