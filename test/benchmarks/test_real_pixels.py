"""What is said of real pixels: harmonics that are there, and corrections from elsewhere."""

from __future__ import annotations

from benchmarks import real_pixels
from benchmarks.field import Field, residuals
from benchmarks.ours import CHAMPION, estimate
from benchmarks.scenes import sample, Scene
from blob_tracker.location.phase_correction import learn_phase_correction, PhaseCorrection
import numpy as np
from numpy.typing import NDArray
import pytest


def field(seed: int, count: int = 60) -> Field:
    """Return a field of windows whose first pixels lie on a grid of whole pixels."""
    seen = sample(Scene(7, 1.1, 50.0), count, seed)
    x0, y0 = np.random.default_rng(seed).integers(0, 500, (2, count)).astype(float)
    return Field(
        f'frame {seed}', seen.windows, x0, y0, x0 + seen.x, y0 + seen.y,
        np.full(count, 50.0), order=1,
    )


def test_correction_is_learned_from_the_other_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    """Learn each frame's correction from all the others' positions and none of its own."""
    fields = [field(seed) for seed in range(3)]
    learned: list[set[float]] = []

    def learn(x: NDArray[np.float64], y: NDArray[np.float64]) -> PhaseCorrection:
        learned.append(set(x))
        return original(x, y)

    original = learn_phase_correction
    monkeypatch.setattr(real_pixels, 'learn_phase_correction', learn)
    real_pixels.phase_corrected(fields)
    own = [set(estimate(each.windows, CHAMPION).x) for each in fields]
    for index in range(3):
        others = [own[other] for other in range(3) if other != index]
        assert learned[index] == set.union(*others)
        assert not learned[index] & own[index]


def test_harmonic_of_a_known_bias() -> None:
    """Find the amplitude of a bias in the residuals to the map, and its rms over the phase."""
    here = field(5, count=2000)
    x, y = here.u - here.x0, here.v - here.y0
    biased = x - 0.05 * np.sin(2.0 * np.pi * here.u), y
    left = residuals(here, biased)
    row = real_pixels._row('stars', 'biased', [left], np.ones(2000, dtype=bool))
    # The map's three terms take up next to nothing of it.
    assert row.harmonic == pytest.approx(0.05, rel=0.03)
    assert row.found == 2000
    # x and y together: the sine's 0.05 / sqrt2, half of it from x; bins of 0.1 px blur it by 2 %.
    assert row.phase_rms == pytest.approx(0.025 / np.sqrt(2.0), rel=0.06)


def test_residuals_leave_an_outlier_out() -> None:
    """Drop one blob that lies a pixel off, and shift no other for it."""
    here = field(6)
    x, y = here.u - here.x0, here.v - here.y0
    noise = 1e-3 * np.random.default_rng(6).standard_normal((2, 60))
    x, y = x + noise[0], y + noise[1]
    x[7] += 1.0
    left = residuals(here, (x, y))
    assert np.isnan(left.x[7])
    assert np.isfinite(left.x).sum() >= 58
    assert np.nanstd(left.x) < 1.5e-3
