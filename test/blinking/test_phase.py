"""The phase filter finds pattern and phase, and knows the instant to its share."""

from __future__ import annotations

from blob_tracker.blinking.patterns import code, SUB_CELLS, Tables, tables
from blob_tracker.blinking.phase import (
    diffuse, expected_share, fill_hit, fill_miss, fill_outlook, fill_prior, learned_wander, OTHERS,
    refine, STEADIEST, weigh_hit, weigh_miss, where,
)
from blob_tracker.blinking.tracks import LEVELS
import numpy as np
from numpy.typing import NDArray
import pytest

RATE = 60.0
PATTERNS = [code('a', '1101011000', 59.7), code('b', '1110010010', 59.7)]
FULL = np.array([1000.0, 0.02, 1e-4])
LEAST = 50.0


def looks(table: Tables, clock: float) -> NDArray[np.int64]:
    """Return by how many looks each pattern has gone on."""
    steps = np.floor(table.rate * clock + 0.5).astype(np.int64)
    return np.asarray(steps % (SUB_CELLS * np.diff(table.first)))


def followed(
    rate_error: float, frames: int
) -> tuple[list[float], list[tuple[float, float, float]]]:
    """Return the probability of the true pattern, and share, tau and its error over sigma."""
    table = tables(PATTERNS, 1 / RATE, 0.5 / RATE)
    cells = int(table.first[-1])
    prior = np.zeros(cells + OTHERS)
    fill_prior(table.first, prior)
    weights, likelihood = prior.copy(), np.zeros(LEVELS)
    random = np.random.default_rng(3)
    offsets = ((np.arange(400) + 0.5) / 400 - 0.5) * 0.5 / RATE
    probabilities, instants = [], []
    for index in range(frames):
        part = ((index / RATE + offsets) * (1 + rate_error) / PATTERNS[0].period + 0.3) % 1.0
        on = np.any([(a <= part) & (part < b) for a, b in PATTERNS[0].edges], axis=0)
        share = float(on.mean())
        diffuse(table.first, prior, weights, -1, 1.0)
        steps = looks(table, float(index))
        if share > 0.1:
            flux = 1000.0 * share * (1.0 + 0.01 * random.standard_normal())
            fill_hit(flux, 5.0, FULL, LEAST, likelihood)
            weigh_hit(table, steps, weights, -1, likelihood)
            moments = np.zeros(5)
            seen = min(flux / 1000.0, 1.0)
            refine(table, steps, weights, -1, seen, 0.012, moments)
            true = float(offsets[on].mean()) * RATE
            instants.append((share, true, (moments[0] - true) / np.sqrt(moments[1] + 1e-9)))
        else:
            fill_miss(FULL, LEAST, likelihood)
            weigh_miss(table, steps, weights, -1, likelihood)
        probabilities.append(float(weights[:table.first[1]].sum()))
    return probabilities, instants


@pytest.mark.parametrize('rate_error', [0.0, 0.01, -0.01])
def test_pattern_and_instant_of_a_light_whose_clock_is_off(rate_error: float) -> None:
    """Named within twelve frames; tau within four sigma but for one in twenty of the frames."""
    probabilities, instants = followed(rate_error, 400)
    assert min(probabilities[12:]) > 0.9
    part = np.array([each for each in instants[20:] if 0.1 < each[0] < 0.98])
    assert len(part) > 60
    assert (np.abs(part[:, 2]) < 4.0).mean() > 0.95


def test_what_is_to_come_has_the_probability_of_its_cells() -> None:
    """The outlook sums to the weights, and its mean share is the expected one."""
    table = tables(PATTERNS, 1 / RATE, 0.5 / RATE)
    cells = int(table.first[-1])
    weights, outlook = np.zeros(cells + OTHERS), np.zeros((4, LEVELS))
    fill_prior(table.first, weights)
    assert weights.sum() == pytest.approx(1.0)
    fill_outlook(table, looks(table, 7.3), weights, -1, outlook)
    assert outlook[0].sum() + outlook[3].sum() == pytest.approx(1.0)
    duty = 0.5  # of both codes
    assert expected_share(outlook) == pytest.approx(
        duty * outlook[0].sum() + outlook[3, 1] + 0.5 * outlook[3, 0], abs=0.01
    )


@pytest.mark.parametrize('steadily, least, most', [(0.0, STEADIEST, 0.2), (0.15, 0.4, 1.0)])
def test_a_clock_that_is_kept_is_trusted(steadily: float, least: float, most: float) -> None:
    """Of phases that are measured to a cell, and go on by so many cells a frame."""
    table = tables(PATTERNS[:1], 1 / RATE, 0.5 / RATE)
    cells = int(table.first[-1])
    random = np.random.default_rng(5)
    prior = np.zeros(cells + OTHERS)
    fill_prior(table.first, prior)
    weights, wander, found = prior.copy(), 1.0, []
    for index in range(600):
        diffuse(table.first, prior, weights, 0, wander)
        about, mean, variance = where(table.first, weights, 0, -1)
        if index % 3 == 0:
            phase = (20.0 + steadily * index + random.standard_normal()) % cells
            away = (np.arange(cells) - phase + cells / 2) % cells - cells / 2
            weights[:cells] *= np.exp(-0.5 * away**2)
            weights[cells:] = 0.0
            weights /= weights.sum()
            wander = learned_wander(
                wander, mean, variance, *where(table.first, weights, 0, about)[1:]
            )
        found.append(wander)
    assert least <= np.median(found[300:]) <= most
