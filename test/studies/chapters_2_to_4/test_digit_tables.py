"""The tables without noise, as the studies lay them beside the thesis."""

from __future__ import annotations

from blob_tracker.studies.chapters_2_to_4.digit_tables import STUDIES
import pytest
from support.quick_study import by_name, quick_findings

STUDY = by_name(STUDIES)


@pytest.mark.parametrize(
    ('name', 'agreement'),
    [
        ('table_3_3', '112 of 120 numbers as printed'),
        ('table_3_4', '147 of 150 numbers as printed'),
        ('table_4_4', '142 of 150 numbers as printed'),
    ],
)
def test_all_but_single_last_digits(name: str, agreement: str) -> None:
    """Those that differ do so by one unit."""
    findings = quick_findings(STUDY[name])
    assert findings.agreement == agreement + ', the others one unit of the last digit off'
    assert findings.checks[0].met


def test_less_than_the_thesis_single_precision() -> None:
    """Table 4.3: a million times smaller in every row."""
    table = quick_findings(STUDY['table_4_3']).tables[0]
    largest = table.columns.index('largest error, px')
    for row in table.rows:
        assert float(row[largest]) < 1e-6 * float(row[largest + 1])


def test_where_ours_is_larger_is_said_so() -> None:
    """Table 4.8: narrow windows end in another minimum, and the words say larger."""
    findings = quick_findings(STUDY['table_4_8'])
    assert findings.agreement.startswith('largest errors larger than printed in 2 of 4 rows')
    assert not findings.checks[0].met


def test_what_the_text_says_of_table_3_4() -> None:
    """The widest of three pulses is placed best, and their SNR are alike."""
    assert [check.met for check in quick_findings(STUDY['table_3_4']).checks[2:]] == [True, True]


def test_three_gaussians_as_printed() -> None:
    """Table 4.9: every digit but one largest error; the SNR give the grid."""
    assert quick_findings(STUDY['table_4_9']).agreement.startswith('19 of 20 numbers as printed')
