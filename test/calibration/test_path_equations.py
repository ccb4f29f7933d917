"""Equations of a path in bands, and what comes of eliminating it."""

from __future__ import annotations

from blob_tracker.calibration.path_equations import add_band, Linear
import numpy as np


def test_the_step_and_the_covariance_are_those_of_the_whole_system() -> None:
    """As a dense solver has them."""
    rng = np.random.default_rng(2)
    outer, size, wide = 3, 12, 4
    columns = np.arange(size - wide + 1)[:, None] + np.arange(wide)
    rows = rng.normal(size=(len(columns), wide))
    shared = rng.normal(size=(len(columns), outer))
    whole = np.zeros((outer + size, outer + size))
    for number, row in enumerate(rows):
        full = np.concatenate([shared[number], np.zeros(size)])
        full[outer + columns[number]] = row
        whole += np.outer(full, full)
    whole[np.diag_indices(outer + size)] += 1.0
    band = np.zeros((wide, size))
    add_band(band, columns, rows)
    band[0] += 1.0
    right = rng.normal(size=outer + size)
    linear = Linear(
        whole[:outer, :outer], whole[:outer, outer:], band, right[:outer], right[outer:])
    step = np.linalg.solve(whole, right)
    for found, expected in zip(linear.step(0.0), (step[:outer], step[outer:]), strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-9)
    np.testing.assert_allclose(
        linear.covariance(), np.linalg.inv(whole)[:outer, :outer], rtol=1e-9)
