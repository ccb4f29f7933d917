"""The SNR of the 1-D figures."""

from __future__ import annotations

from blob_tracker.studies.chapters_2_to_4.snr_tables import STUDIES
import pytest
from support.quick_study import by_name, quick_findings

STUDY = by_name(STUDIES)


@pytest.mark.parametrize(
    ('name', 'agreement'),
    [
        ('table_3_1', '3 of 3 rows agree in every printed digit'),
        ('table_4_1', '5 of 6 numbers as printed, the others one unit of the last digit off'),
        ('table_4_6', '6 of 6 rows agree in every printed digit'),
    ],
)
def test_digits(name: str, agreement: str) -> None:
    """Without noise all is as printed, to one unit of one number."""
    assert quick_findings(STUDY[name]).agreement == agreement


@pytest.mark.parametrize('name', ['table_3_2', 'table_4_2'])
def test_noise(name: str) -> None:
    """What is printed lies among our repeats."""
    assert quick_findings(STUDY[name]).checks[0].met


def test_contradictions_of_the_thesis_come_out_again() -> None:
    """Table 4.6 falls once where its text has it rise; Table 4.7 is Table 3.2."""
    rises = quick_findings(STUDY['table_4_6']).checks[1]
    assert rises.found == '4' and rises.met
    assert [check.met for check in quick_findings(STUDY['table_4_7']).checks] == [True]
