"""Lights that look alike keep their numbers while they move, and are believed after a while."""

from __future__ import annotations

from blob_tracker.segmentation.numbering import Numbering
from support.contrasts import candidate_at


def test_numbers_stay_with_lights_that_move_together() -> None:
    """By 8 px a frame, seen in another order each time; one that was hidden keeps its own."""
    numbering = Numbering(3, 20.0)
    places = [(10, 10), (40, 10), (10, 40)]
    for frame in range(6):
        lights = [candidate_at(x + 8 * frame, y) for x, y in places]
        if frame == 2:
            lights.pop(1)
        if frame % 2:
            lights.reverse()
        found = dict(numbering.take(frame, lights))
        expected = {
            f'light_{number + 1}': x + 8 * frame
            for number, (x, _) in enumerate(places) if frame != 2 or number != 1
        }
        assert {name: each.x for name, each in found.items()} == expected


def test_the_strongest_count_of_too_many() -> None:
    """And those that are out of the gate are others."""
    numbering = Numbering(2, 20.0)
    weak = candidate_at(80, 10, snr=8.0)
    first = [candidate_at(10, 10), candidate_at(40, 10), weak]
    assert [each.x for _, each in numbering.take(1, first)] == [10.0, 40.0]
    found = numbering.take(2, [candidate_at(40, 10), weak])
    assert [(name, each.x) for name, each in found] == [('light_1', 80.0), ('light_2', 40.0)]


def test_what_flashes_is_believed_in_every_other_frame() -> None:
    """From the third time on; a frame too early or too late it begins anew."""
    numbering = Numbering(2, 20.0, period=2, least_run=3)
    frames = [1, 3, 5, 7, 8, 10, 12, 15, 17, 19]
    believed = [frame for frame in frames if numbering.take(frame, [candidate_at(10, 10)])]
    assert believed == [5, 7, 12, 19]
