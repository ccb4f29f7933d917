"""The budget of a light, held against the virtual lab's photons and against what it must obey."""

from __future__ import annotations

from math import inf

from blob_tracker.camera import CameraModel, pinhole_matrix
from blob_tracker.location import locate_batch
from blob_tracker.radiometry import Led, link_budget, OpticsError, Receiver, Surroundings
from blob_tracker.simulation import flashing_light, Optics, Sensor
import numpy as np
import pytest

SIDE, RADIUS, PAIRS = 121, 6, 400  # px, px, count
CAMERA = Receiver(filter_width=10.0)
BUDGET = link_budget(Led(1.0), CAMERA, Surroundings(), 1000.0)


def test_the_lab_counts_as_many_electrons_and_scatters_by_the_bound() -> None:
    """
    A scene of the budget's peak, background, pattern and sigma, through the lab's sensor.

    The mean of 400 flashes is the budget's count to four standard errors. Positions by the default
    method scatter by the bound: to 12 %, three standard errors of the rms of 2 x 400 of them.
    """
    gain, level = CAMERA.noise.gain, BUDGET.background / CAMERA.noise.gain
    scene = flashing_light(
        width=SIDE, height=SIDE, sigma=BUDGET.sigma, background=level, texture=0.2 * level,
        amplitude=BUDGET.electrons / (2.0 * np.pi * BUDGET.sigma**2) / gain,
        sensor=Sensor(CAMERA.noise, bits=CAMERA.bits, full_well=CAMERA.full_well),
    )
    windows, truth = [], []
    for index in range(PAIRS):
        place = scene.truth(2 * index)
        left, top = round(place.x) - RADIUS, round(place.y) - RADIUS
        truth.append((place.x - left, place.y - top))
        windows.append([
            scene.frame(2 * index + each)[top:top + 2 * RADIUS + 1, left:left + 2 * RADIUS + 1]
            for each in (0, 1)
        ])
    lit, unlit = np.swapaxes(np.array(windows, dtype=float), 0, 1)
    counts = gain * (lit - unlit).sum(axis=(1, 2))
    assert abs(counts.mean() - BUDGET.electrons) < 4.0 * counts.std() / np.sqrt(PAIRS)
    found = locate_batch(lit, unlit, noise=CAMERA.noise)
    errors = np.column_stack([found.x, found.y]) - truth
    assert found.ok.all()
    assert 0.88 < np.sqrt((errors**2).mean()) / BUDGET.bound_px < 1.12


def test_it_falls_with_the_distance_as_the_lab_does() -> None:
    """With the square, and what the air takes; a ball of 1 m, whose image is resolved."""
    light = Led(1.0, diameter=1.0)
    near, far = (link_budget(light, CAMERA, Surroundings(), each) for each in (100.0, 300.0))
    taken = far.transmittance / near.transmittance
    assert near.electrons / far.electrons * taken == pytest.approx(9.0)
    lens = 1e3 * CAMERA.focal_length / CAMERA.pixel  # px
    camera = CameraModel(101, 101, pinhole_matrix(lens, 101, 101))
    optics = Optics(camera, CAMERA.sigma(Led(1.0, diameter=1e-9), 100.0))
    spots = [optics.spot((0.0, 0.0, each), 1.0, 100.0) for each in (100.0, 300.0)]
    assert [each.sigma for each in spots] == pytest.approx([near.sigma, far.sigma], rel=1e-6)
    whole = [each.amplitude * each.sigma**2 for each in spots]
    assert whole[0] / whole[1] == pytest.approx(9.0, rel=1e-6)


def test_sunlight_drowns_a_light_that_a_filter_saves() -> None:
    """3 W at 1 km: without a filter the scene alone fills the pixels; with 10 nm it is found."""
    open_ = link_budget(Led(3.0), Receiver(), Surroundings(), 1000.0)
    assert open_.verdict == 'the background alone saturates the pixels'
    assert open_.bound_px == inf
    fits = Receiver(exposure=open_.fitting_exposure)
    short = link_budget(Led(3.0), fits, Surroundings(), 1000.0)
    assert short.full == pytest.approx(0.7)
    assert short.verdict == 'drowned by the light behind it'
    filtered = link_budget(Led(3.0), CAMERA, Surroundings(), 1000.0)
    assert filtered.verdict == 'found' and filtered.snr > 5.0 * short.snr
    assert link_budget(Led(3.0), CAMERA, Surroundings(), 20_000.0).verdict == 'too faint'


def test_a_difference_is_worth_more_the_more_pattern_there_is() -> None:
    """Without one it costs the root of two, as the background's noise is there twice."""
    even = link_budget(Led(1.0), CAMERA, Surroundings(texture=0.0), 1000.0)
    assert even.snr / even.snr_one_frame == pytest.approx(np.sqrt(0.5))
    assert BUDGET.snr / BUDGET.snr_one_frame > 10.0
    assert BUDGET.snr == even.snr


@pytest.mark.parametrize('flash', [0.0, 20e-6, 5e-3])
def test_the_exposure_that_fits(flash: float) -> None:
    """The peak is then at 70 % of full scale, for a flash shorter or longer than it too."""
    light = Led(3.0, flash=flash)
    fit = link_budget(light, Receiver(), Surroundings(), 500.0).fitting_exposure
    found = link_budget(light, Receiver(exposure=fit), Surroundings(), 500.0)
    assert found.full == pytest.approx(0.7)


def test_the_bound_is_that_of_photons_alone_where_they_are_many() -> None:
    """At night sigma / sqrt(N) for an unsampled blob; the pixels cost a tenth at 0.83 px."""
    night = link_budget(Led(3.0), Receiver(), Surroundings(light='night'), 1000.0)
    assert 1.0 < night.bound_px / (night.sigma / np.sqrt(night.electrons)) < 1.15
    assert night.bound_mrad == pytest.approx(night.bound_px * 3.45 / 25.0)


def test_the_bound_of_a_wide_blob_takes_larger_pixels() -> None:
    """
    It is as sigma^2, as it is before a bright background, across where they begin, at 16 px.

    To 0.2 % there, which is that they are not integrated over; at 540 px the blob's own photons
    are 3 % less.
    """
    before, after, wide = (
        link_budget(Led(1.0, diameter=each), CAMERA, Surroundings(), 100.0)
        for each in (0.8789, 0.8851, 30.0))
    assert before.sigma < 16.0 < after.sigma
    assert after.bound_px / before.bound_px == pytest.approx(
        (after.sigma / before.sigma)**2, rel=2e-3)
    assert wide.bound_px / after.bound_px == pytest.approx(
        (wide.sigma / after.sigma)**2, rel=0.03)


@pytest.mark.parametrize('diameter, distance', [(0.005, 0.001), (0.005, 0.249), (3.0, 1.0)])
def test_a_light_that_is_too_near_is_refused(diameter: float, distance: float) -> None:
    """Within ten focal lengths, or wider than the sensor."""
    with pytest.raises(OpticsError, match='10 focal lengths and an image of 10000 px at most'):
        link_budget(Led(1.0, diameter=diameter), CAMERA, Surroundings(), distance)
