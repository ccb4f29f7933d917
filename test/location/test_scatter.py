"""The scatter of places against the one that their covariances predict."""

from __future__ import annotations

from blob_tracker.location import locate_batch
from blob_tracker.location.scatter import RecentPlaces, scatter
from blob_tracker.simulation import expose, flashing_light, pixel_integrated_gaussian
from blob_tracker.types import Location, SensorNoise
import numpy as np
import pytest

COUNT = 240
RUNS = 150
RATE = 30.0  # lit frames a second of the demo
COVARIANCE = np.array([[0.02**2, 0.3 * 0.02 * 0.03], [0.3 * 0.02 * 0.03, 0.03**2]])  # px^2
LIGHT = flashing_light()


def still(times):
    """Return a place that stays, px."""
    return np.zeros((times.size, 2))


def straight(times):
    """Return a place that crosses the frame at the demo's greatest speed, px."""
    return np.stack([300.0 * times, -200.0 * times], axis=1)


def demo(times):
    """Return the path of the demo's light, px."""
    truths = [LIGHT.truth(time * LIGHT.rate) for time in times]
    return np.array([[truth.x, truth.y] for truth in truths])


def observed(random, motion, *, jitter=0.0, understated=1.0, count=COUNT):
    """Return stamps, places and covariances of a target, the noise changing from one to next."""
    times = random.uniform(0.0, 9.0) + (
        np.arange(count) + random.uniform(-jitter, jitter, count)
    ) / RATE
    scale = np.exp(random.normal(0.0, 0.2, count))
    noise = random.normal(size=(count, 2)) @ np.linalg.cholesky(COVARIANCE).T * scale[:, None]
    covariances = COVARIANCE * (scale[:, None, None] / understated) ** 2
    return (1e9 * times).astype(np.int64), motion(times) + noise, covariances


@pytest.mark.parametrize('understated', [1.0, 2.0])
@pytest.mark.parametrize('jitter', [0.0, 0.3])
@pytest.mark.parametrize('motion', [still, straight, demo])
def test_the_ratio_is_true_within_its_error(motion, jitter, understated):
    """Whatever the motion and the stamps: sigmas of half the true size say 2."""
    random = np.random.default_rng(1)
    found = [
        scatter(*observed(random, motion, jitter=jitter, understated=understated))
        for _ in range(RUNS)
    ]
    ratios = np.array([each.ratio for each in found])
    errors = np.array([each.error for each in found])
    # Four standard errors of the mean of the runs; the root of a mean square is low by
    # 1 / (4 freedom) = 0.0014 by itself.
    assert ratios.mean() == pytest.approx(
        understated, abs=4.0 * errors.mean() / RUNS**0.5 + 0.0014 * understated
    )
    # The scatter of 150 runs is known to 1 / sqrt(300) = 6 %; three of those.
    assert ratios.std() == pytest.approx(errors.mean(), rel=0.18)
    assert sum(each.exceeds(1.5) for each in found) == (0 if understated == 1.0 else pytest.approx(
        RUNS, abs=0.1 * RUNS
    ))


def test_stamps_that_jitter_are_told_from_places_that_do():
    """1 ms of jitter in the stamps is 0.3 px at the demo's speed; the places are at even times."""
    random = np.random.default_rng(7)
    stamps, places, covariances = observed(random, demo)
    found = scatter(stamps + random.normal(0.0, 1e6, COUNT).astype(np.int64), places, covariances)
    assert abs(found.ratio - 1.0) < 3.0 * found.error
    assert found.by_stamps > 3.0


def test_a_source_that_stalls_is_no_scatter():
    """Places at even steps, and stamps of which each tenth is as late as one step and more."""
    random = np.random.default_rng(8)
    stamps, places, covariances = observed(random, demo)
    late = np.cumsum(np.arange(COUNT) % 10 == 0) * int(1.2e9 / RATE)
    found = scatter(stamps + late, places, covariances)
    assert abs(found.ratio - 1.0) < 3.0 * found.error


def test_the_degrees_of_freedom_of_equal_intervals():
    """2 M / 2.63 for M differences of fourth order, but for the ends."""
    stamps = np.arange(1000) * 10**7
    places = np.random.default_rng(2).normal(size=(1000, 2))
    found = scatter(stamps, places, np.broadcast_to(np.eye(2), (1000, 2, 2)))
    # C(16, 8) / C(8, 4)^2; the ends have fewer neighbours: 4 of 1000.
    assert found.freedom == pytest.approx(2 * 996 / (12870 / 4900), rel=4e-3)


def test_an_error_that_follows_the_pixels_shows():
    """A centroid without its correction in windows of 5 px: biased by the place in the pixel."""
    noise = SensorNoise(gain=40.0, read_noise=0.7)
    random = np.random.default_rng(3)
    times = np.arange(COUNT) / RATE
    places = 10.0 + np.stack([7.3 * times, 4.1 * times], axis=1)
    corners = np.round(places).astype(int) - 2
    ratios = {}
    windows = []
    for place, corner in zip(places, corners):
        x, y = place - corner
        light = 20.0 + 150.0 * pixel_integrated_gaussian((5, 5), x, y, 1.2)
        windows.append(expose(light, noise, random, saturation=255))
    dark = [expose(np.full((5, 5), 20.0), noise, random, saturation=255) for _ in windows]
    for method in ('centroid', 'maximum_likelihood'):
        found = locate_batch(
            np.array(windows), np.array(dark), method=method, noise=noise, saturation=255
        )
        assert found.ok.all()
        ratios[method] = scatter(
            (1e9 * times).astype(np.int64),
            corners + np.stack([found.x, found.y], axis=1),
            found.covariance,
        )
    assert ratios['centroid'].exceeds(1.5)
    assert abs(ratios['maximum_likelihood'].ratio - 1.0) < 3.0 * ratios['maximum_likelihood'].error


def test_gaps_and_jumps_are_left_out():
    """A pause, a stamp that goes back and another target for a moment are no noise."""
    random = np.random.default_rng(4)
    stamps, places, covariances = observed(random, still)
    stamps[80:] += 5 * 10**9
    stamps[160:] -= 8 * 10**9
    places[160:] += 100.0
    places[40] += 300.0
    found = scatter(stamps, places, covariances)
    assert abs(found.ratio - 1.0) < 3.0 * found.error
    assert found.jumps == 5  # fourth differences that have one place in them
    # 236, less 4 across either gap, less these 5, 2.63 of which are one.
    assert found.freedom == pytest.approx(2 * (COUNT - 4 - 8 - 5) / 2.63, rel=0.03)


def test_too_few_say_nothing():
    """12 differences need 16 places."""
    random = np.random.default_rng(5)
    assert scatter(*observed(random, still, count=15)) is None
    assert scatter(*observed(random, still, count=16)) is not None
    stamps, places, covariances = observed(random, still)
    assert scatter(np.zeros_like(stamps), places, covariances) is None
    stamps = np.cumsum(np.where(np.arange(COUNT) % 4, 1, 50)) * 10**7
    assert scatter(stamps, places, covariances) is None


def test_the_ring_keeps_the_last_places_in_their_order():
    """The same as of the arrays, from whatever place in the ring."""
    random = np.random.default_rng(6)
    stamps, places, covariances = observed(random, demo)
    recent = RecentPlaces(100)
    for stamp_ns, (x, y), covariance in zip(stamps, places, covariances):
        chi2 = 1.0 if stamp_ns < stamps[-50] else 2.0
        recent.add(Location(x, y, covariance, 1.0, 0.0, 1.0, 1.0, chi2, 0, int(stamp_ns)))
    assert recent.scatter() == scatter(stamps[-100:], places[-100:], covariances[-100:])
    assert recent.chi2 == pytest.approx(1.5)
    assert (recent.last.x, recent.last.y) == tuple(places[-1])
    assert RecentPlaces(100).scatter() is None
