"""What a turn within the exposure adds to a place is what its innovation speaks for."""

from __future__ import annotations

from blob_tracker.blinking.turns import counted_turns, fill_bend, LEAST_TURNS, TURNS
import numpy as np
import pytest

HALF, GAP = 0.25, 2.0  # frame intervals


@pytest.mark.parametrize('speed, sigma', [(2.0, 0.05), (10.0, 0.1)])
def test_the_covariance_is_that_of_turns_at_random(speed: float, sigma: float) -> None:
    """
    Of lights drawn by the model: in the mean over all, and over those with a large innovation.

    There are 1,500 turns in 100,000 exposures; with the tails of what they add 10 % are 3 sigma.
    """
    random = np.random.default_rng(1)
    count = 100_000
    t = random.uniform(-GAP + HALF, HALF, count)
    turns = random.uniform(size=count) < TURNS * GAP
    changed = speed * turns[:, None] * random.standard_normal((count, 2))
    within = np.abs(t) < HALF
    moved = np.where(within, (HALF - t) ** 2 / (4 * HALF), -t)
    off = np.where(within, (HALF - np.abs(t)) ** 2 / (4 * HALF), 0.0)
    seen = moved[:, None] * changed + sigma * random.standard_normal((count, 2))
    told = np.empty((count, 3))
    probability = np.array([
        fill_bend(dx, dy, sigma**2, speed, HALF, GAP, TURNS, out)
        for (dx, dy), out in zip(seen, told)
    ])
    square = ((off[:, None] * changed) ** 2).sum(axis=1)
    stated = told[:, 0] + told[:, 2]
    assert stated.mean() == pytest.approx(square.mean(), rel=0.2)
    large = np.hypot(*seen.T) > 5.0 * sigma
    assert stated[large].mean() == pytest.approx(square[large].mean(), rel=0.2)
    assert probability.mean() == pytest.approx(turns.mean(), rel=0.1)


def test_the_middle_of_a_bent_streak_is_off_by_that() -> None:
    """Against the mean over the exposure, for a turn at its middle: u h / 4."""
    speed = 10.0
    times = (np.arange(1000) + 0.5) / 1000 * 2 * HALF - HALF
    middle = float(np.where(times > 0.0, speed * times, 0.0).mean())
    assert middle == pytest.approx(speed * HALF / 4, rel=1e-3)
    out = np.empty(3)
    # What is known of it is between nothing and twice that innovation.
    fill_bend(middle, 0.0, 0.02**2, speed, HALF, GAP, LEAST_TURNS, out)
    assert 0.2 * middle < np.sqrt(out[0]) < 2.0 * middle
    assert out[2] < 0.05 * out[0]


def test_turns_are_counted() -> None:
    """One in 40 frames, of which every second shows the light, then none for 1,000."""
    turns, mean = LEAST_TURNS, []
    for index in range(1000):
        turns = counted_turns(turns, float(index % 20 == 0), 2.0)
        mean.append(turns)
    assert np.mean(mean[500:]) == pytest.approx(1 / 40, rel=0.2)
    for _ in range(500):
        turns = counted_turns(turns, 0.0, 2.0)
    assert turns == pytest.approx(LEAST_TURNS, rel=0.01)
