"""Interlaced pictures of the kernel's own driver: lines, order and time of their fields."""

from __future__ import annotations

from collections import Counter
import json
from typing import Any

import numpy as np
import pytest

pytestmark = pytest.mark.timeout(60, func_only=True)  # the boot is watched by itself

STEP = 12  # px that the driver moves its pattern from field to field
CASES = {  # words, lines of the picture, field rate
    'TV, 525 lines': ('bottom before top, line by line', 480, 60 / 1.001),
    'S-Video, 625 lines': ('top before bottom, line by line', 576, 50.0),
    'seq_tb': ('top before bottom, one above the other', 576, 50.0),
    'bottom': ('bottom alone', 576, 25.0),
    'alternate': ('one after the other', 576, 50.0),
}


@pytest.fixture(params=CASES)
def case(request, results) -> tuple[dict[str, Any], str, int, float]:
    """Give what guest_fields.py found of a case, and what is right."""
    found = json.loads((results / 'fields.json').read_text())[request.param]
    return (found, *CASES[request.param])


def test_each_field_is_a_frame(case):
    found, words, lines, rate = case
    assert found['fields'] == words
    assert found['sensor_size'] == [720, lines]
    assert found['frame_rate'] == pytest.approx(rate, rel=1e-6)
    assert found['pixel_aspect'] == pytest.approx(11 / 10 if lines == 480 else 54 / 59)
    assert {tuple(shape) for shape in found['shapes']} == {((lines - 1) // 2, 720)}
    assert {tuple(each) for each in found['binning']} == {(1, 2)}
    # One after the other; a lost one is as often of this kind as of that.
    kinds = found['y0']
    if words == 'bottom alone':
        assert set(kinds) == {1}
    else:
        turns = np.count_nonzero(np.diff(kinds))
        assert turns >= len(kinds) // 3


def test_lines_go_to_their_field(case):
    # Even lines of the picture are white, odd ones are black, or the other way round.
    found = case[0]
    levels: dict[int, set[int]] = {}
    for kind, least, most in found['levels']:
        assert least == most
        levels.setdefault(kind, set()).add(least)
    assert all(len(each) == 1 for each in levels.values())
    if len(levels) == 2:
        assert levels[0] != levels[1]


def test_fields_are_in_the_order_of_time(case):
    # The driver moves its pattern by as much from field to field. The wrong order would go back
    # by a step within a picture, and on by three to the next.
    found, words, _, rate = case
    step = STEP if words != 'bottom alone' else 2 * STEP
    # A machine that stalls loses fields: the stamps tell which follow each other.
    apart = np.diff(found['stamps'])
    shifts = np.array(found['shifts'])
    period = 1e9 / rate
    following = np.abs(apart - period) < 0.2 * period
    assert following.any()
    (usual, _), = Counter(np.abs(shifts[following]).tolist()).most_common(1)
    assert usual == step
    if found['per_buffer'] == 2:
        first = np.array(found['y0'][:-1]) == (1 if words.startswith('bottom') else 0)
        pairs = first & (np.abs(apart - period) <= 2)
        assert pairs.sum() >= len(shifts) // 4
        assert set(shifts[pairs]) == {shifts[pairs][0]} and abs(shifts[pairs][0]) == step
        assert set(shifts[~pairs & following]) <= {shifts[pairs][0]}
    assert np.all(np.diff(found['stamps']) > 0)
