"""Charge that a pixel cannot hold goes along its column, and none is lost on the way."""

from blob_tracker.simulation.blooming import spill
import numpy as np
import pytest


def test_charge_is_conserved_and_no_pixel_holds_more_than_it_can() -> None:
    """Column by column; what is not full beside it keeps what it has."""
    random = np.random.default_rng(1)
    charge = random.uniform(0.0, 50.0, (200, 30)).astype(np.float32)
    charge[90:110, 10:14] = 400.0
    before = charge.copy()
    spill(charge, 100.0)
    # Sums of 10^4 in single precision.
    np.testing.assert_allclose(charge.sum(axis=0), before.sum(axis=0), rtol=1e-5)
    assert charge.max() <= 100.0 + 1e-3
    others = [column for column in range(30) if not 10 <= column < 14]
    np.testing.assert_array_equal(charge[:, others], before[:, others])


def test_it_runs_up_as_far_as_down() -> None:
    """One pixel of 9 wells in the middle of an empty column: four more full on either side."""
    charge = np.zeros((41, 3), dtype=np.float32)
    charge[20, 1] = 900.0
    spill(charge, 100.0)
    expected = np.zeros((41, 3))
    expected[16:25, 1] = 100.0
    np.testing.assert_allclose(charge, expected, atol=1e-3)


def test_it_leaves_at_the_end_of_the_column() -> None:
    """Two wells of room above, none below."""
    charge = np.zeros((3, 1), dtype=np.float32)
    charge[2, 0] = 500.0
    spill(charge, 100.0)
    assert charge[:, 0] == pytest.approx([100.0, 100.0, 100.0])


def test_frames_of_a_stack_do_not_meet() -> None:
    """Each is as if alone."""
    stack = np.zeros((2, 9, 4), dtype=np.float32)
    stack[0, 4, 1], stack[1, 2, 3] = 300.0, 500.0
    alone = [each.copy() for each in stack]
    spill(stack, 100.0)
    for together, single in zip(stack, alone, strict=True):
        spill(single, 100.0)
        np.testing.assert_allclose(together, single, atol=1e-4)
