"""How much light a point has, where its top is clipped too."""

from __future__ import annotations

from blob_tracker.segmentation import Segmenter
from blob_tracker.segmentation.points import unclipped_flux
from blob_tracker.segmentation.single_frames import seen_points, SingleFrames
from blob_tracker.types import Frame
import numpy as np
import pytest

SATURATION, BACKGROUND, SIGMA = 255, 30.0, 1.5


class Watched(SingleFrames):
    """Keeps the points of the last frame."""

    def choose(self, contrast, candidates):
        """Name nothing."""
        self.table = seen_points(contrast, candidates)[1]
        self.reason = 'none'
        return []

    locked = False


@pytest.mark.parametrize('peak', [400.0, 1300.0, 3000.0])
def test_a_clipped_light_has_its_light(peak: float) -> None:
    """2 pi sigma^2 times the peak to 7 %, up to 13 times full scale; its sigma says so."""
    random = np.random.default_rng(1)
    watched = Watched(0.0)
    segmenter = Segmenter(flash=watched)
    rows, columns = np.indices((60, 80))
    pulse = peak * np.exp(-((columns - 40.3) ** 2 + (rows - 30.4) ** 2) / 2.0 / SIGMA**2)
    for index in range(8):
        mean = BACKGROUND + pulse
        pixels = mean + np.sqrt(mean / 10.0 + 1.0) * random.standard_normal(mean.shape)
        image = np.clip(np.rint(pixels), 0, SATURATION).astype(np.uint8)
        segmenter.sightings(Frame(image, index * 16_666_667, SATURATION))
    (point,) = watched.table
    true = 2.0 * np.pi * SIGMA**2 * peak
    assert point[5] == pytest.approx(true, rel=0.07)
    assert abs(point[5] - true) < 3.0 * point[6]


def test_flanks_that_tell_nothing_leave_the_light_open() -> None:
    """No amplitude above what is seen: any light."""
    assert unclipped_flux(1000.0, 225.0, 0.0) == (1000.0, 1000.0)
