"""The likelihood ratio of a track over chance is one: chance has no gain in the mean."""

from __future__ import annotations

from blob_tracker.segmentation.chance import advance, FIELDS, FLASHES, FRAME, KIND, KINDS, SCORE
from blob_tracker.segmentation.chance import LIGHT_BRIGHTNESS, LIGHT_CHANCE, STEADY, VAR_V, VAR_X
from blob_tracker.segmentation.chance import X, Y
import numpy as np
import pytest

GATE = 24.0  # px
SIZE, RANGE = 160.0, 4.0  # px and e-folds over which glints are


def track(kind: int) -> np.ndarray:
    """Return a track in the middle, of the speed that it has after two flashes."""
    row = np.zeros((1, FIELDS))
    shake, turn = KINDS[kind]
    row[0, [X, Y, KIND, SCORE, FRAME]] = SIZE / 2, SIZE / 2, kind, 10.0, 0.0
    row[0, VAR_X], row[0, VAR_V] = shake**2, 2.0 * shake**2 + turn**2
    row[0, FLASHES] = 2.0
    return row


def glints(random: np.random.Generator, density: float) -> np.ndarray:
    """Return lights anywhere and of any brightness, so many a px^2."""
    lights = np.zeros((random.poisson(density * SIZE**2), 6))
    lights[:, :2] = random.uniform(0.0, SIZE, (len(lights), 2))
    lights[:, LIGHT_BRIGHTNESS] = random.uniform(-RANGE / 2, RANGE / 2, len(lights))
    lights[:, LIGHT_CHANCE] = np.log(density / RANGE)
    lights[:, 5] = 1.0
    return lights


@pytest.mark.parametrize('kind', range(len(KINDS)))
def test_chance_gains_nothing_in_the_mean(kind: int) -> None:
    """The ratios of all that may go on sum up to the one before: to which chance is bound."""
    random = np.random.default_rng(40 + kind)
    start = track(kind)
    sums = [
        np.exp(
            advance(start, np.empty((0, 7)), glints(random, 2e-3), 2.0, GATE)[:, SCORE] - 10.0
        ).sum()
        for _ in range(20_000)
    ]
    # Glints beyond four sigma are left out, and so is what is fainter or brighter than 4 e-folds.
    error = np.std(sums) / np.sqrt(len(sums))
    assert np.mean(sums) == pytest.approx(1.0, abs=4.0 * error + 0.005)


def test_a_target_gains_and_a_miss_costs() -> None:
    """At its place by more than three e-folds; a miss is one in ten."""
    light = np.array([[SIZE / 2, SIZE / 2, 0.0, 0.0, np.log(2e-3 / RANGE), 1.0]])
    seen = advance(track(1), np.empty((0, 7)), light, 2.0, GATE)
    assert seen[:, SCORE].max() > 13.0
    assert advance(track(1), np.empty((0, 7)), light[:0], 2.0, GATE)[0, SCORE] == pytest.approx(
        10.0 + np.log(0.1)
    )


def test_what_lights_up_between_two_flashes_speaks_against_a_light_at_its_place_alone() -> None:
    """A rejected one as well."""
    at = np.array([[SIZE / 2, SIZE / 2, 0.0, 0.0, np.log(2e-4), 0.0]])
    aside = at + np.array([[20.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
    here, there, none = (
        advance(track(1), np.empty((0, 7)), lights, 1.0, GATE)[0, STEADY]
        for lights in (at, aside, at[:0])
    )
    assert here < -2.0 < 0.0 < there == none
