"""The loops over pixels of this room, compiled before the first frame needs them."""

from __future__ import annotations

from blob_tracker.segmentation.blink import compile_blinking
from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.chance import advance, FIELDS
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.drift import light_at
from blob_tracker.segmentation.flash_watch import FlashWatch
from blob_tracker.segmentation.search import search
from blob_tracker.types import Frame
import numpy as np


def compile_ahead() -> None:
    """Compile them, or load them from Numba's cache."""
    for kind in (np.uint8, np.uint16):
        unlit = np.zeros((16, 16), kind)
        lit = unlit.copy()
        lit[7:10, 7:10] = 100
        frame = Frame(lit, 0, 255)
        contrast = Contrast(lit, unlit, 255, frame, (lit,), (unlit,))
        light = search(contrast, Box(0, 0, 16, 16), min_snr=7.0).candidates[0]
        light_at(lit, 8.0, 8.0, 1.0)
        FlashWatch().add(lit, unlit, light, (8.0, 8.0), (1.0, 1.0, 0.5, 0.5))
    advance(np.empty((0, FIELDS)), np.empty((0, 7)), np.empty((0, 6)), 0.0, 1.0)
    compile_blinking()
