"""Each threshold is reached by its name, with its own options, and finds the same light."""

from __future__ import annotations

from blob_tracker.location import locate
from blob_tracker.segmentation import Segmenter, threshold_by_name, THRESHOLDS
from blob_tracker.simulation import flashing_light, pixel_integrated_gaussian
from blob_tracker.types import Frame
import numpy as np
import pytest
from support.contrasts import candidate_at, contrast_of

SCENE = flashing_light(width=160, height=120, period=3.0)


@pytest.mark.parametrize('method', THRESHOLDS)
def test_each_method_finds_the_light(method: str) -> None:
    """Every lit frame gives a window, and the light is placed within the thesis' 0.05 px rms."""
    segmenter = Segmenter(threshold=threshold_by_name(method, sigmas=3.0, extension=2))
    errors = []
    for index in range(60):
        window = segmenter.update(Frame(SCENE.frame(index), 1 + round(index * 1e9 / 60), 255))
        if window is not None:
            found, truth = locate(window, noise=SCENE.sensor.noise), SCENE.truth(index)
            errors.append((found.x - truth.x, found.y - truth.y))
    assert len(errors) == 29  # the first lit frame has none before it
    assert np.sqrt(np.mean(np.square(errors))) < 0.05


def test_options_reach_their_methods() -> None:
    """More sigma or more pixels make a larger window."""
    light = np.rint(200 * pixel_integrated_gaussian((120, 160), 80.0, 60.0, 3.0)).astype(np.uint8)
    contrast, peak = contrast_of(light), candidate_at(80, 60, sigma_x=3.0, sigma_y=3.0)
    for method in ('sigma_window', 'histogram_extended'):
        small = threshold_by_name(method, sigmas=2.0, extension=1)(contrast, peak, 50)
        large = threshold_by_name(method, sigmas=4.0, extension=7)(contrast, peak, 50)
        assert small is not None and large is not None
        assert (large.x1 - large.x0) - (small.x1 - small.x0) == 12


def test_an_unknown_method_is_named() -> None:
    """With those that there are."""
    with pytest.raises(ValueError, match="no threshold method 'best'; there is sigma_window, "):
        threshold_by_name('best', sigmas=3.0, extension=2)
