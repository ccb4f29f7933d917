"""How a camera is turned by TF, beside the angles of the same joints."""

from __future__ import annotations

from math import sin
from types import SimpleNamespace

from blob_tracker.nodes.tracker.camera_turns import CameraTurns, HALF_NS
from blob_tracker.tracking import PanTiltAngles, PlatformGap
from blob_tracker.tracking.rotation import pan_tilt
from blob_tracker.transforms import Found, Transform, TransformTree
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

MS = 1_000_000
START_NS = 10**18


def joints(stamp_ns: int) -> tuple[float, float]:
    """Return pan and tilt, rad: at up to 1 rad/s and 3 rad/s^2."""
    seconds = 1e-9 * (stamp_ns - START_NS)
    return 0.3 * sin(3.0 * seconds), 0.1 * sin(4.0 * seconds + 1.0)


@pytest.fixture
def turns() -> CameraTurns:
    """Give what knows 300 ms of a pan/tilt, each 10 ms."""
    tree = TransformTree()
    for stamp_ns in range(START_NS, START_NS + 301 * MS, 10 * MS):
        turn = Rotation.from_matrix(pan_tilt(*joints(stamp_ns)))
        tree.put('camera', 'base', Transform(rotation=tuple(turn.as_quat())), stamp_ns)
    transforms = SimpleNamespace(lookup=tree.lookup, explain=lambda gap: f'because {gap}')
    made = CameraTurns(transforms, 'base')  # type: ignore[arg-type]
    made.camera = 'camera'
    return made


def test_turns_and_rates_are_those_of_the_joints(turns: CameraTurns) -> None:
    """Of the camera against the base, in its axes; the interval of the rate bends by 3 mrad/s."""
    angles = PanTiltAngles()
    for stamp_ns in range(START_NS, START_NS + 301 * MS, MS):
        angles.push(stamp_ns, *joints(stamp_ns))
    for ms in (20.0, 33.3, 150.0, 287.0):
        stamp_ns = START_NS + round(ms * MS)
        # 3 rad/s^2 over 10 ms: 0.04 mrad.
        np.testing.assert_allclose(turns.at(stamp_ns), pan_tilt(*joints(stamp_ns)), atol=6e-5)
        # The joints' rate is over the last 8 ms, that of TF over 10 about the instant.
        np.testing.assert_allclose(turns.rate_at(stamp_ns), angles.rate_at(stamp_ns), atol=0.03)


def test_the_rate_is_that_until_the_newest_where_no_more_is_known(turns: CameraTurns) -> None:
    """The ray that has just been waited for has one too; before the first there is none."""
    newest_ns = START_NS + 300 * MS
    before = np.array(joints(newest_ns - 2 * HALF_NS))
    pan_rate = (joints(newest_ns)[0] - before[0]) / (2e-9 * HALF_NS)
    assert turns.rate_at(newest_ns)[1] == pytest.approx(pan_rate, rel=1e-3)
    with pytest.raises(PlatformGap, match='because the oldest transform'):
        turns.rate_at(START_NS)


def test_what_may_come_is_awaited(turns: CameraTurns) -> None:
    """And what is of long ago is not."""
    assert not turns.awaits(START_NS + 300 * MS)
    assert turns.awaits(START_NS + 301 * MS)
    assert not turns.awaits(START_NS - 1)
    with pytest.raises(PlatformGap, match="because the newest transform of 'camera' in 'base'"):
        turns.at(START_NS + 301 * MS)


def test_a_turn_that_was_awaited_is_looked_up_once(turns: CameraTurns) -> None:
    """For the next ray alone: after a jump of the clock its stamp may come with another turn."""
    stamps: list[int] = []
    lookup = turns._transforms.lookup

    def counted(frame: str, reference: str, stamp_ns: int) -> Found:
        stamps.append(stamp_ns)
        return lookup(frame, reference, stamp_ns)

    turns._transforms.lookup = counted  # type: ignore[method-assign]
    first_ns, next_ns = START_NS + 33 * MS, START_NS + 66 * MS
    expected = pan_tilt(*joints(first_ns))
    assert not turns.awaits(first_ns)
    np.testing.assert_allclose(turns.at(first_ns), expected, atol=6e-5)
    assert stamps == [first_ns]
    np.testing.assert_allclose(turns.at(first_ns), expected, atol=6e-5)
    assert stamps == [first_ns] * 2
    assert not turns.awaits(first_ns)
    np.testing.assert_allclose(turns.at(next_ns), pan_tilt(*joints(next_ns)), atol=6e-5)
    assert stamps == [first_ns] * 3 + [next_ns]


def test_its_deviation_is_that_which_is_said(turns: CameraTurns) -> None:
    """About each axis."""
    turns.sigma = 1e-3
    assert turns.variances_at(START_NS) == (1e-6, 1e-6)
