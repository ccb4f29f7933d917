"""A light that goes over from the lit frames to the unlit ones, and what only seems to."""

from __future__ import annotations

from blob_tracker.segmentation.drift import (
    light_at, no_drift, no_instants, take_flash, take_place,
)
from blob_tracker.simulation import pixel_integrated_gaussian
import numpy as np
import pytest

INTERVAL = 1.0 / 30.0  # s from flash to flash
NOISE = 10.0  # DN px^2, of a light of 1000


def watched(lit: np.ndarray, unlit: np.ndarray) -> list[float]:
    """Return what is told flash by flash."""
    random = np.random.default_rng(5)
    drift = no_drift()
    return [
        take_flash(
            drift, index * INTERVAL, a + random.normal(0, NOISE), b + random.normal(0, NOISE)
        )[0]
        for index, (a, b) in enumerate(zip(lit, unlit))
    ]


@pytest.mark.parametrize('rate', [0.03, 0.2, -0.2, 0.8])  # of the light, a second
def test_a_drift_is_seen_with_its_rate(rate: float) -> None:
    """A tenth of it is enough; the rate is that of the line to within four of its deviations."""
    over = np.clip((0.0 if rate > 0 else 0.5) + rate * np.arange(190) * INTERVAL, 0.0, 0.5)
    told = watched(1000.0 * (1.0 - over), 1000.0 * over)
    first = next(index for index, each in enumerate(told) if each)
    moved = abs(over[first] - over[0])
    assert 0.05 < moved < 0.35
    assert told[first] == pytest.approx(rate, rel=0.35)


@pytest.mark.parametrize('lit, unlit', [
    (np.full(190, 1000.0), np.zeros(190)),
    # Never quite off.
    (np.full(190, 700.0), np.full(190, 300.0)),
    # It recedes.
    (np.linspace(1000.0, 100.0, 190), np.zeros(190)),
    # It passes a lamp, which is in both frames.
    (1000.0 + 600.0 * np.exp(-((np.arange(190) - 95.0) / 10.0) ** 2),
     600.0 * np.exp(-((np.arange(190) - 95.0) / 10.0) ** 2)),
], ids=['in step', 'never off', 'recedes', 'passes a lamp'])
def test_nothing_else_is_a_drift(lit: np.ndarray, unlit: np.ndarray) -> None:
    """Not in any of the 190 flashes."""
    assert not any(watched(lit, unlit))


def test_the_share_that_went_over_is_what_both_say() -> None:
    """No more than noise until then; then a tenth to within three of its deviations."""
    random = np.random.default_rng(6)
    drift = no_drift()
    for index in range(40):
        over = 0.1 * (index >= 30)
        _, share = take_flash(
            drift, index * INTERVAL, 1000.0 * (1.0 - over) + random.normal(0, NOISE),
            1000.0 * over + random.normal(0, NOISE),
        )
        if index < 30:
            assert share == 0.0
    assert share == pytest.approx(0.1, abs=0.04)


@pytest.mark.parametrize('ahead, side', [(-1.0, 1), (1.0, -1), (0.0, 0), (-3.0, 0), (5.0, 0)])
def test_the_ghost_tells_the_side(ahead: float, side: int) -> None:
    """Half an exposure behind or ahead; not where it is always on, filtered, or anything else."""
    random = np.random.default_rng(7)
    instants = no_instants()
    for _ in range(20):
        take_place(instants, ahead + random.normal(0, 0.3), 0.3, 3.0, 0.0)
    assert instants.counts[1] == side


def test_the_light_at_a_place() -> None:
    """Its sum above the surroundings, and its centre: of a Gaussian 99 % within three sigma."""
    image = np.round(40.0 + 150.0 * pixel_integrated_gaussian((40, 40), 19.3, 21.1, 2.0))
    total, (x, y), count = light_at(image.astype(np.uint8), 20.0, 20.0, 2.0)
    assert total == pytest.approx(150.0 * 2.0 * np.pi * 4.0, rel=0.04)
    assert (x, y) == pytest.approx((19.3, 21.1), abs=0.15)
    assert count == pytest.approx(np.pi * 36.0, rel=0.05)
    assert light_at(image.astype(np.uint8), 500.0, 20.0, 2.0) == (0.0, (500.0, 20.0), 0)


@pytest.mark.parametrize('background', [0.0, 180.0])
def test_the_background_draws_the_light_nowhere(background: float) -> None:
    """The pixels within a circle are not even about its centre; 0.03 px is what is cut off."""
    for x in (19.9, 20.1, 20.3):
        pulse = pixel_integrated_gaussian((40, 40), x, 20.0, 1.5)
        image = np.round(background + 60.0 * pulse).astype(np.uint8)
        _, found, _ = light_at(image, 20.2, 20.2, 1.5)
        assert found == pytest.approx((x, 20.0), abs=0.03)


def test_texture_behind_the_light_tells_no_side() -> None:
    """Its places have nothing to do with the exposure: however many there are, no side is told."""
    random = np.random.default_rng(8)
    instants = no_instants()
    for _ in range(5000):
        # A little nearer to the side of the late, as the texture happens to be.
        take_place(instants, random.normal(-2.0, 6.0), 0.3, 12.0, 0.0)
        assert instants.counts[1] == 0


def test_a_light_that_is_beside_its_way_tells_no_side() -> None:
    """Its lines are cut: in the unlit frame it is lower, whichever way it goes."""
    random = np.random.default_rng(5)
    instants = no_instants()
    for angle in np.linspace(0.0, 2.0 * np.pi, 40):
        ahead, aside = 1.0 * np.sin(angle), 1.0 * np.cos(angle)
        take_place(instants, ahead + random.normal(0, 0.25), 0.25, 3.0, aside)
        assert instants.counts[1] == 0
