"""Whether a number is placed among repeats as often as the interval says."""

from __future__ import annotations

from blob_tracker.studies.chapters_2_to_4.sampling import likely_count, place_among
import numpy as np


def test_interval_holds_a_further_repeat_as_often_as_it_says() -> None:
    """Of 2000 experiments of 5 repeats, 95 % and 99 %, to three standard deviations."""
    random = np.random.default_rng(1)
    places = [
        place_among(f'{value:.6f}', repeats)
        for *repeats, value in np.exp(0.2 * random.standard_normal((2000, 6)))
    ]
    assert abs(np.mean([place.within_95 for place in places]) - 0.95) < 0.015
    assert abs(np.mean([place.within_99 for place in places]) - 0.99) < 0.007


def test_rounding_of_the_printed_number_is_allowed_for() -> None:
    """0.0000 stands for all that rounds to it."""
    repeats = [0.000031, 0.000029, 0.000030]
    assert place_among('0.0000', repeats).score == 0.0
    assert not place_among('0.000050', repeats).within_99


def test_likely_count() -> None:
    """The first percentile of a binomial: 20 of 20 are in the interval in 36 of 100 tables."""
    assert likely_count(20, 0.95) == 16
