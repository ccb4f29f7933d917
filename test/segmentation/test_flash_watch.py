"""What the flashes of a light in step tell, from the pixels of its pairs."""

from __future__ import annotations

from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.flash_watch import FlashWatch, Seen
from blob_tracker.simulation import pixel_integrated_gaussian
import numpy as np
import pytest

INTERVAL, EXPOSURE = 1.0 / 60.0, 0.4 / 60.0  # s
SHAPE, SIGMA, PEAK, NOISE = (60, 300), 1.5, 120.0, 0.7
SPEED = 90.0  # px/s


def picture(random: np.random.Generator, x: float, part: float) -> np.ndarray:
    """Return a frame with so much of the light at a place."""
    mean = 20.0 + part * PEAK * pixel_integrated_gaussian(SHAPE, x, 30.2, SIGMA)
    return np.rint(random.normal(mean, NOISE)).astype(np.uint8)


def found(x: float) -> Candidate:
    """Return what the segmenter found there: only its place, width and noise are asked for."""
    blank = Candidate._make([0.0] * len(Candidate._fields))
    return blank._replace(x=x, y=30.0, sigma_major=SIGMA, sigma_minor=SIGMA, noise=1.0)


def watched(parts: np.ndarray, late: float = 0.0) -> list[Seen]:
    """Return what is told of flashes of which such parts went over; `late` in exposures."""
    random = np.random.default_rng(2)
    watch = FlashWatch()
    before, told = (60.0 - 2.0 * INTERVAL * SPEED, 30.2), []
    for index, part in enumerate(parts):
        x = 60.0 + 2.0 * index * INTERVAL * SPEED
        lit = picture(random, x + late * EXPOSURE * SPEED, 1.0 - part)
        unlit = picture(random, x - (INTERVAL + late * EXPOSURE) * SPEED, part)
        stamp = 2.0 * index * INTERVAL
        times = (stamp, 2.0 * INTERVAL, INTERVAL, EXPOSURE)
        told.append(watch.add(lit, unlit, found(x), before, times))
        before = told[-1].x, told[-1].y
    return told


def test_a_light_in_step_is_seen_where_it_is_and_how_fast() -> None:
    """To 0.05 px and, between two such places 33 ms apart, to 4 px/s; nothing goes over."""
    for index, each in enumerate(watched(np.zeros(40))):
        assert each.x == pytest.approx(60.0 + 2.0 * index * INTERVAL * SPEED, abs=0.05)
        assert each.vx == pytest.approx(SPEED, abs=4.0)
        assert (each.going_over, each.share, each.side) == (0.0, 0.0, 0)
        assert each.unlit < 0.05


def test_a_light_that_goes_over_is_seen_with_its_rate_and_side() -> None:
    """A quarter of it in 60 flashes; it lay ahead in the lit frame, at the end of the exposure."""
    parts = np.linspace(0.0, 0.25, 60)
    told = watched(parts, late=0.5)
    rates = [each.going_over for each in told if each.going_over]
    assert rates
    assert rates[-1] == pytest.approx(0.25 / (118.0 * INTERVAL), rel=0.2)
    assert told[-1].share == pytest.approx(0.25, abs=0.04)
    assert told[-1].unlit == pytest.approx(0.25, abs=0.04)
    assert told[-1].side == 1


def test_what_is_forgotten_is_not_told() -> None:
    """A watch that begins anew is as a new one."""
    random = np.random.default_rng(3)
    watch = FlashWatch()
    light = found(60.0)
    lit, unlit = picture(random, 60.0, 0.8), picture(random, 60.0, 0.2)

    def run() -> list[Seen]:
        return [
            watch.add(
                lit, unlit, light, (60.0, 30.2), (index / 30.0, 1.0 / 30.0, INTERVAL, EXPOSURE)
            )
            for index in range(20)
        ]

    first = run()
    watch.forget()
    assert run() == first
