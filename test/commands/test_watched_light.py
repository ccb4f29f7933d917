"""A light's locations against its truth: at their own instants, and by what they claim."""

from __future__ import annotations

from blob_tracker.commands.watched_light import BUDGET, Score, WatchedLight
import numpy as np
import pytest

INTERVAL = 16_666_667  # ns


def place(stamp: int) -> tuple[float, float]:
    """Return a place on a path of 9 s, px."""
    angle = 2e-9 * np.pi * stamp / 9.0
    return 300.0 + 224.0 * np.sin(2 * angle), 200.0 + 168.0 * np.sin(3 * angle)


def test_the_truth_is_that_of_the_instant_that_the_location_claims() -> None:
    """It was seen in two frames of five, up to 3 ms from the middle; the tracker says another."""
    random = np.random.default_rng(1)
    light = WatchedLight()
    for index in range(200):
        if index % 5 < 2:
            stamp = 10**18 + index * INTERVAL
            light.truths[stamp + random.integers(-3_000_000, 3_000_000)] = (0.0, 0.0)
            light.centroids[stamp + random.integers(-3_000_000, 3_000_000)] = (0.0, 0.0)
    for store in (light.truths, light.centroids):
        store.update((stamp, place(stamp)) for stamp in store)
    located, true = light.matched(INTERVAL)
    assert len(located) == 80
    # Of a spline through knots 0.06 s apart: some thousandths of a px at the ends of the path.
    assert np.abs(located - true).max() < 0.01


def test_a_location_of_a_frame_in_which_the_light_was_off_is_false() -> None:
    """Between the first truth and the last; those of other frames are matched with none."""
    light = WatchedLight()
    light.truths = {k * INTERVAL: place(k * INTERVAL) for k in (0, 2, 4, 6)}
    light.centroids = {k * INTERVAL: (1.0, 1.0) for k in (2, 3, 6, 7)}
    assert light.matched_stamps(INTERVAL) == [2 * INTERVAL, 6 * INTERVAL]
    assert light.false_stamps(INTERVAL) == [3 * INTERVAL]
    light.forget()
    assert light.matched_stamps(INTERVAL) == light.false_stamps(INTERVAL) == []


def test_the_score_is_of_those_that_claim_the_budget() -> None:
    """Errors as large as their sigma: a scatter of 1, and an rms of the sure ones alone."""
    random = np.random.default_rng(2)
    sigmas = np.where(np.arange(1000) % 4 == 0, 0.5, 0.02)
    errors = sigmas[:, None] * random.standard_normal((1000, 2))
    covariances = sigmas[:, None, None] ** 2 * np.eye(2)
    score = Score(np.zeros((1000, 2)), errors, covariances)
    assert score.sure.sum() == 750
    assert score.rms == pytest.approx(0.02, rel=0.1)
    assert score.scatter == pytest.approx(1.0, abs=0.1)
    assert score.words.startswith('1000 bearings, 750 of them with a sigma of 0.05 px or less, ')
    unsure = np.broadcast_to(4 * BUDGET**2 * np.eye(2), (1000, 2, 2))
    assert Score(errors, errors, unsure).rms == np.inf
