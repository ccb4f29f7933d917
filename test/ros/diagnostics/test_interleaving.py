"""Several publishers by the numbers of their messages."""

from __future__ import annotations

from blob_tracker.ros.diagnostics.interleaving import Interleaving, SILENCE_NS

INTERVAL_NS = SILENCE_NS // 50


def test_two_publishers_are_told_from_one() -> None:
    """Of one the numbers rise, also where some are missing, and begin again once."""
    one, two = Interleaving(), Interleaving()
    for index, number in enumerate([7, 8, 11, 12, 1, 2, 3]):
        one.took(number, index * INTERVAL_NS)
        assert not one.mixed
    for index, number in enumerate([7, 101, 8, 102, 9]):
        two.took(number, index * INTERVAL_NS)
    assert two.mixed
    # The other one has ended.
    two.took(10, 5 * INTERVAL_NS + SILENCE_NS)
    assert not two.mixed


def test_two_that_began_together() -> None:
    """Their numbers are alike."""
    interleaving = Interleaving()
    for index in range(6):
        interleaving.took(index // 2, index * INTERVAL_NS)
    assert interleaving.mixed
