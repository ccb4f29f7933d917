"""The bearings of the benchmark: a truth of its own, and a covariance that holds."""

from __future__ import annotations

from benchmarks import bearing
import numpy as np


def test_truth_is_what_the_camera_model_finds_back() -> None:
    """Agree both ways through the lens, all over the picture."""
    angles, pixels = bearing.directions(200, np.random.default_rng(1))
    found = np.array([bearing.LENS.angles(x, y)[:2] for x, y in pixels])
    # The model's iteration ends at 1e-10 px; a pixel is about 1.1 mrad.
    np.testing.assert_allclose(found, angles, atol=1e-8)
    assert (pixels.min(axis=0) > 19.0).all() and (pixels.max(axis=0) > (1200.0, 680.0)).all()


def test_nees_over_all_scenes() -> None:
    """Have two, over the twenty scenes together."""
    rows = bearing.run(100, lambda _: None)
    assert len(rows) == bearing.steps() == 20
    count = sum(row.count for row in rows)
    assert count >= 1990  # hardly one without an answer
    mean = sum(row.nees * row.count for row in rows) / count
    # 2.6 standard errors of 2 / sqrt(2000): beyond it once in a hundred seeds, and this is one.
    assert abs(mean - 2.0) < 2.6 * 2.0 / count**0.5
