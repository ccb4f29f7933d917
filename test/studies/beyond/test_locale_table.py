"""Locales, and the look-up beside the other locators: what the quick run is to show."""

from __future__ import annotations

from blob_tracker.studies.beyond.locale_table import STUDY
from blob_tracker.studies.study import Findings
import numpy as np
import pytest
from support.quick_study import measured, quick_findings


@pytest.fixture(scope='module')
def findings() -> Findings:
    """Run the quick study; its timing once and on few windows, since nothing is asked of it."""
    cases = [
        {**case, 'count': 50, 'repeats': 1} if case['kind'] == 'speed' else case
        for case in STUDY.cases(True)
    ]
    return quick_findings(STUDY, cases)


def test_every_check_is_met(findings: Findings) -> None:
    """At the bound, with a true covariance, without a bias."""
    assert len(findings.checks) == 4
    assert [check for check in findings.checks if not check.met] == []


def test_locales_shrink_with_the_amplitude(findings: Findings) -> None:
    """As 1 / A: a level of the slope A g' is passed every 1 / (A g') px, in as many pixels."""
    table = findings.tables[0]
    for s in (1.0, 1.5, 2.0, 3.0):
        rows = {row[1]: row for row in table.rows if row[0] == s}
        ratio = float(rows[50.0][2] or 0.0) / float(rows[4000.0][2] or 1.0)
        assert ratio == pytest.approx(80.0, rel=0.2)  # 25 places of each axis, 10 % scatter
        # Who is not told amplitude and width cannot do as well as the exact map.
        assert all(float(row[2] or 0.0) < float(row[8 + 1] or 0.0) for row in rows.values())


def test_where_it_loses(findings: Findings) -> None:
    """Clipped blobs are refused, and tilted ones cost half as much again."""
    shapes = {row[0]: row for row in findings.tables[3].rows}
    columns = list(findings.tables[3].columns)
    table, fit = (
        columns.index(f'{method} rms, px') for method in ('locale_table', 'maximum_likelihood')
    )
    assert shapes['Gaussian, clipped at half its peak'][table] is None
    tilted = shapes['ellipse, axes 1.5 to 1, at 45 degrees']
    assert float(tilted[table] or 0.0) > 1.3 * float(tilted[fit] or 0.0)
    round_one = shapes['Gaussian, sigma 1.5 px']
    assert float(round_one[table] or 0.0) < 1.05 * float(round_one[fit] or 0.0)


def test_one_colour_of_the_picture_is_one_rounded_window(findings: Findings) -> None:
    """Five levels leave some hundred locales in a pixel, symmetric about its middle."""
    case = STUDY.cases(True)[0]
    found = measured(STUDY, case)[0]
    number = np.array(found['number']).reshape(160, 160)
    assert 150 < found['count'] < 400
    # Mirrored places have mirrored windows: as many places to a locale on either side.
    left = np.sort(np.unique(number[:, :80], return_counts=True)[1])
    right = np.sort(np.unique(number[:, 80:], return_counts=True)[1])
    np.testing.assert_array_equal(left, right)
    assert 'locale_table_locales' in findings.figures
