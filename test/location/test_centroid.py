"""The centroid: its arithmetic, its efficiency where it is good, its failures."""

from blob_tracker.location import locate, locate_batch
from blob_tracker.location.centroid import centroid_1d
from blob_tracker.types import LocationError, SensorNoise, Window
import numpy as np
import pytest

NOISE = SensorNoise(gain=4.0, read_noise=1.0)


def test_1d_is_the_ratio_of_sums():
    """Weigh the places with the light, along the last axis."""
    assert centroid_1d([0.0, 1.0, 3.0, 0.0]) == pytest.approx(1.75)
    np.testing.assert_allclose(centroid_1d([[1.0, 0.0, 1.0], [0.0, 0.0, 2.0]]), [1.0, 2.0])
    assert np.isnan(centroid_1d([1.0, -1.0]))


def test_background_is_taken_off(scene):
    """Have no bias toward the middle where the window holds the whole pulse."""
    shots = scene(13, 1.3, 500.0, count=2000, noise=NOISE, background=100.0)
    errors = shots.errors(shots.locate('centroid'))
    slope = np.polyfit(shots.x - 6.0, errors[:, 0], 1)[0]
    # Left in, 100 DN on 169 pixels would draw it in by three quarters.
    assert abs(slope) < 0.01


def test_reported_width_and_height(scene):
    """Return the pulse' sigma and amplitude from the moments."""
    found = scene(13, 1.3, 500.0, count=500, noise=NOISE, unlit=True).locate('centroid')
    assert np.median(found.sigma) == pytest.approx(1.3, rel=0.02)
    assert np.median(found.amplitude) == pytest.approx(500.0, rel=0.04)


def test_no_light_is_a_failure():
    """Refuse a sum within its noise."""
    random = np.random.default_rng(0)
    lit = np.rint(50.0 + random.standard_normal((9, 9)))
    with pytest.raises(LocationError, match='no light'):
        locate(Window(lit, np.full((9, 9), 50)), method='centroid', noise=NOISE)


def test_outside_is_a_failure():
    """Refuse a ratio that leaves the window."""
    lit = np.zeros((1, 5, 5))
    lit[0, :, 0], lit[0, :, 4] = -300.0, 400.0
    found = locate_batch(lit, np.zeros_like(lit), method='centroid', noise=NOISE)
    assert not found.ok[0]
