"""Share and time of each phase are those of the integrals; edges are those of the bits."""

from __future__ import annotations

from blob_tracker.blinking.patterns import code, look, tables, wave
import numpy as np
import pytest


@pytest.mark.parametrize('bits, edges', [
    ('1000', ((0.0, 0.25),)),
    ('0110', ((0.0, 0.5),)),
    ('1001', ((0.0, 0.5),)),  # one run, over the end
    ('101100', ((0.0, 1 / 6), (2 / 6, 4 / 6))),
])
def test_runs_of_bits_are_edges(bits: str, edges: tuple[tuple[float, float], ...]) -> None:
    """Begun at a rise, wherever the code begins."""
    np.testing.assert_allclose(code('a', bits, 10.0).edges, edges)


def test_the_longest_dark_time() -> None:
    """Over the end of the code, too."""
    assert code('a', '0100110', 10.0).longest_dark == pytest.approx(0.2)
    assert wave('a', 10.0, 0.3).longest_dark == pytest.approx(0.07)


@pytest.mark.parametrize('exposure', [0.004, 0.013, 0.06])
def test_share_and_time_are_the_integrals(exposure: float) -> None:
    """Against 20,000 samples of the exposure, also where several flashes fall into it."""
    pattern = code('a', '1101000', 60.0)
    share, tau = look(pattern, 70, exposure)
    offsets = ((np.arange(20_000) + 0.5) / 20_000 - 0.5) * exposure
    for step in range(0, 70, 3):
        phase = ((step + 0.5) / 70 + offsets / pattern.period) % 1.0
        on = np.any([(a <= phase) & (phase < b) for a, b in pattern.edges], axis=0)
        assert share[step] == pytest.approx(on.mean(), abs=2e-4)
        if on.any():
            assert tau[step] == pytest.approx(offsets[on].mean(), abs=2e-4 * exposure + 1e-9)


def test_an_edge_within_the_exposure_is_a_straight_line() -> None:
    """With tau = +-(1 - s) E / 2 the slope is -+E / 2, also at the looks beside a whole one."""
    table = tables([wave('a', 6.0, 0.5)], 1 / 60, 0.5 / 60)
    partly = (table.share > 0.0) & (table.share < 1.0)
    np.testing.assert_allclose(
        np.abs(table.tau[partly]), 0.25 * (1.0 - table.share[partly]), atol=1e-9
    )
    np.testing.assert_allclose(
        table.slope[partly], -0.25 * np.sign(table.tau[partly]), atol=1e-6
    )
    assert table.slope[table.share == 0.0].max() == 0.0
