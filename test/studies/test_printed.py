"""The thesis' numbers as data: all there, with their digits."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from blob_tracker.studies import printed
from blob_tracker.studies.printed import load, units_off
import pytest

NAMES = [
    f'table_{chapter}_{n}'
    for chapter, count in ((2, 1), (3, 5), (4, 10)) for n in range(1, count + 1)
] + ['figure_2_3'] + [
    f'figure_{chapter}_{n}' for chapter, count in ((3, 7), (4, 12)) for n in range(1, count + 1)
]


@pytest.mark.parametrize('name', NAMES)
def test_each_table_and_figure_is_there(name: str) -> None:
    """Under its own number and page, with rows or statements."""
    kind, chapter, number = name.split('_')
    content = load(name)
    assert content.source.startswith(f'{kind.capitalize()} {chapter}.{number}, page ')
    assert content.rows if kind == 'table' else content.statements
    assert (files('blob_tracker.studies.printed') / f'{name}.yaml').is_file()


def test_tables_of_errors_have_five_windows_and_six_widths() -> None:
    """No row is lost, none is there twice."""
    for name in ('table_3_3', 'table_3_4', 'table_3_5', 'table_4_3', 'table_4_4', 'table_4_5'):
        assert [row[:2] for row in load(name).rows] == [
            (size, s) for size in ('5', '7', '9', '15', '25')
            for s in ('1', '3', '5', '7', '10', '15')
        ]


@pytest.mark.parametrize(
    ('rows', 'complaint'),
    [("[['1', '2.50'], ['1', 2.50]]", 'in quotes'), ("[['1', '2'], ['1']]", 'a row of 1')],
)
def test_lost_digits_and_short_rows_are_refused(
    rows: str, complaint: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """2.50 without quotes would be read as 2.5."""
    (tmp_path / 'table_9_9.yaml').write_text(
        f'source: Table 9.9, page 1\ncolumns: [a, b]\nrows: {rows}\n'
    )
    monkeypatch.setattr(printed, 'files', lambda package: tmp_path)
    with pytest.raises(ValueError, match=complaint):
        load('table_9_9')


def test_units_of_the_last_digit() -> None:
    """Rounded alike, then counted; a zero has no sign."""
    assert units_off(0.1234, '0.12') == 0
    assert units_off(0.1251, '0.12') == 1
    assert units_off(0.09, '0.12') == -3
    assert units_off(0.0000004, '-0.000000') == 0
    assert units_off(227.0, '227') == 0
