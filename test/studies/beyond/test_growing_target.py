"""The target that grows: followed tenfold and on, at the bound, until it is too large."""

from __future__ import annotations

from blob_tracker.studies.beyond.growing_target import _target, STUDY
from blob_tracker.studies.study import Findings
import pytest
from support.quick_study import quick_findings


@pytest.fixture(scope='module')
def findings() -> Findings:
    """Approach once under each light."""
    cases = [case for case in STUDY.cases(True) if case['seed'] == 0]
    return quick_findings(STUDY, cases)


def test_it_is_followed_tenfold_and_at_the_bound(findings: Findings) -> None:
    """Every check of the study is met: no flash lost, and 1.3 times the bound in any size."""
    assert len(findings.checks) == 5
    assert [check for check in findings.checks if not check.met] == []


def test_it_ends_at_max_blob(findings: Findings) -> None:
    """Three sigma fill the 128 px of the largest window: from sigma 40 to 43 px."""
    ends = {row[0]: row for row in findings.tables[1].rows}
    for light in ('even exposure, peak to 180 DN', 'exposure control'):
        assert 40.0 < float(ends[light][2] or 0.0) < 43.0
        assert 'max_blob' in str(ends[light][4])


def test_covariance_along_the_way(findings: Findings) -> None:
    """
    NEES lies about 2 wherever 40 errors or more are counted together.

    Of 20 flashes it scatters by 16 % of 2; three and a half of those are allowed for.
    """
    for light, *row in findings.tables[0].rows:
        if 'disc' not in str(light) and row[3] is not None and float(row[2] or 0.0) > 0.5:
            assert 0.9 < float(row[7] or 0.0) < 3.1


def test_brightness_follows_the_range() -> None:
    """Inverse square while the lens makes the picture, and the radiance when it is resolved."""
    far, nearer, near = _target(0, 200.0), _target(1, 200.0), _target(399, 200.0)
    # The light is peak times sigma^2, and goes with the square of the target's own picture.
    light = nearer.peak * nearer.sigma**2 / (far.peak * far.sigma**2)
    assert light == pytest.approx((nearer.own / far.own) ** 2)
    assert near.peak == pytest.approx(200.0, rel=1e-3)
    assert near.sigma > 10.0 * far.sigma
