"""The tables with noise: the reading that gives them, and one that does not."""

from __future__ import annotations

from blob_tracker.studies.chapters_2_to_4.noise_tables import measure
from blob_tracker.studies.chapters_2_to_4.sampling import place_among
from blob_tracker.studies.printed import load
import numpy as np
import pytest

# Standard deviations of a sixth repeat: beyond it by chance once in 5000 (t with 4 degrees).
FAR = 13.0


def scores(table: str, size: int, s: int, reading: int) -> list[float]:
    """Return where mean, variance, largest error and SNR lie among five repeats."""
    case = {
        'table': table, 'window': size, 's': s, 'reading': reading, 'seed': 0, 'repeats': 5
    }
    repeats = np.array(measure(case)['repeats'])
    row = next(row for row in load(table).rows if row[:2] == (str(size), str(s)))
    return [abs(place_among(row[3 + k], repeats[:, 1 + k]).score) for k in range(4)]


@pytest.mark.parametrize(
    ('table', 'size', 's'), [('table_3_5', 25, 1), ('table_4_5', 9, 1), ('table_4_10', 15, 1)]
)
def test_what_is_printed_is_a_draw_of_ours(table: str, size: int, s: int) -> None:
    """The first reading explains all four numbers of the row that tells readings apart."""
    assert max(scores(table, size, s, 0)) < FAR


@pytest.mark.parametrize(('table', 'size'), [('table_3_5', 25), ('table_4_5', 9)])
def test_rounding_before_the_noise_is_not_what_was_done(table: str, size: int) -> None:
    """As the text has it, the wide window's SNR would be far from the printed one."""
    reading = {'table_3_5': 4, 'table_4_5': 2}[table]
    assert max(scores(table, size, 1, reading)) > 3 * FAR
