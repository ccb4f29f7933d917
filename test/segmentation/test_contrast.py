"""Lit less unlit, cut out with its sign."""

from typing import Any

from blob_tracker.segmentation.box import Box
import numpy as np
import pytest
from support.contrasts import contrast_of


@pytest.mark.parametrize('kind', [np.uint8, np.uint16])
def test_signal_keeps_the_sign_and_the_place(kind: Any) -> None:
    """Unsigned types do not wrap around."""
    lit, unlit = np.full((4, 6), 9, kind), np.full((4, 6), 9, kind)
    lit[1, 2], unlit[2, 3] = 20, 250
    signal = contrast_of(lit, unlit).signal(Box(2, 1, 4, 3))
    assert signal.tolist() == [[11, 0], [0, -241]]


def test_signal_without_an_unlit_frame_is_the_frame() -> None:
    """Nothing is taken off."""
    frame = np.arange(24, dtype=np.uint8).reshape(4, 6)
    assert contrast_of(frame).signal(Box(1, 0, 3, 2)).tolist() == [[1, 2], [7, 8]]
