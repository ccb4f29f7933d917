"""17: frames that were compressed as JPEG, one by one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from benchmarks.world.light import digitised, flashing, plain
from benchmarks.world.situation import Floats, PEAK, SHAPE, Shot, Situation
from blob_tracker.capture.pixel_formats.jpeg import luma_quantisation
from blob_tracker.types import Pixels
import cv2
import numpy as np

DIM = 60.0  # DN: the tables take more of a faint light


def frames(
    count: int, random: np.random.Generator, quality: int, peak: float
) -> Iterator[Shot]:
    """Yield a light in frames of a JPEG quality; what the tables take away has no bound."""

    def develop(mean: Floats, source: np.random.Generator) -> Pixels:
        _, data = cv2.imencode(
            '.jpg', digitised(mean, source), [cv2.IMWRITE_JPEG_QUALITY, quality]
        )
        return np.asarray(cv2.imdecode(data, cv2.IMREAD_GRAYSCALE), dtype=np.uint8)

    _, data = cv2.imencode('.jpg', np.zeros(SHAPE, np.uint8), [cv2.IMWRITE_JPEG_QUALITY, quality])
    steps = luma_quantisation(data.tobytes())
    for shot in flashing(count, random, partial(plain, peak=peak), develop=develop):
        yield replace(shot, model=None, quantisation=steps)


SITUATIONS = [
    Situation(
        17, f'JPEG, light of {peak:g} DN', f'quality {quality}',
        partial(frames, quality=quality, peak=peak), r'JPEG|MJPG|compress|codec',
    )
    for peak in (PEAK, DIM)
    for quality in (95, 90, 80, 60)
]
