"""Frames in each other, at the stamps of transforms, between them, and where nobody knows."""

from __future__ import annotations

from math import pi

from blob_tracker.transforms import NoTransform, Transform, TransformError, TransformTree
from blob_tracker.transforms.tree import MOST_FRAMES, MOST_PARENTS
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

MS = 1_000_000
NOW = 10**18


def turned(yaw: float, x: float = 0.0) -> Transform:
    """Return a transform that is turned about z."""
    return Transform((x, 0.0, 0.0), tuple(Rotation.from_euler('z', yaw).as_quat()))


@pytest.fixture
def tree() -> TransformTree:
    """Return map > boat > pan (which turns by 1 rad/s, each 10 ms) > camera, and boat > imu."""
    made = TransformTree()
    made.put_static('boat', 'map', turned(0.5, 10.0))
    made.put_static('camera', 'pan', turned(0.1, 1.0))
    made.put_static('imu', 'boat', turned(pi / 2))
    for step in range(11):
        made.put('pan', 'boat', turned(1e-2 * step), NOW + 10 * MS * step)
    return made


def test_any_frame_in_any_other(tree: TransformTree) -> None:
    """By the frames above both alone, forth and back."""
    found = tree.lookup('camera', 'map', NOW + 33 * MS)
    assert found.moving == ('pan',)
    yaw = 0.5 + 0.033
    np.testing.assert_allclose(found.transform.translation, [10 + np.cos(yaw), np.sin(yaw), 0.0])
    np.testing.assert_allclose(found.transform.matrix, turned(yaw + 0.1).matrix, atol=1e-15)
    back = tree.lookup('map', 'camera', NOW + 33 * MS).transform
    np.testing.assert_allclose(back.matrix, found.transform.matrix.T, atol=1e-15)
    # What hangs by links that hold for good is known at any time.
    mount = tree.lookup('imu', 'map', 1)
    assert mount.moving == ()
    np.testing.assert_allclose(mount.transform.matrix, turned(0.5 + pi / 2).matrix, atol=1e-15)
    assert tree.lookup('camera', 'camera', 1).transform == Transform()
    assert tree.frames == ['boat', 'camera', 'imu', 'map', 'pan']


def test_the_order_of_arrival_changes_nothing(tree: TransformTree) -> None:
    """Late ones are put in their place; one that comes twice is no news."""
    other = TransformTree()
    for step in (5, 0, 10, 3, 3, 1, 7, 2, 9, 4, 8, 6):
        other.put('pan', 'boat', turned(1e-2 * step), NOW + 10 * MS * step)
    for ms in np.linspace(0, 100, 41):
        stamp_ns = NOW + round(ms * MS)
        assert other.lookup('pan', 'boat', stamp_ns) == tree.lookup('pan', 'boat', stamp_ns)


@pytest.mark.parametrize('frame, reference, ms, words, may_come', [
    ('camera', 'map', 101, "newest transform of 'pan' in 'boat' is 0.001 s too old", True),
    ('camera', 'map', -5, "oldest transform of 'pan' in 'boat' that is kept is 0.005 s", False),
    ('camera', 'odom', 0, "nothing was said of 'odom'; publish where 'map' lies in 'odom'", True),
    ('lidar', 'boat', 0, "nothing was said of 'lidar'; publish where 'lidar' lies in 'map'", True),
    ('camera', '', 0, 'the name of a frame is empty', False),
    ('/camera', 'map', 0, "'/camera' begins with /", False),
])
def test_what_is_not_known_is_said_and_whether_it_may_come(
    frame: str, reference: str, ms: int, words: str, may_come: bool, tree: TransformTree
) -> None:
    """Nothing is extrapolated."""
    with pytest.raises(NoTransform, match=words) as raised:
        tree.lookup(frame, reference, NOW + ms * MS)
    assert raised.value.may_come is may_come


def test_how_far_it_is_off_is_told(tree: TransformTree) -> None:
    """An hour is no delay: the clock is another one."""
    with pytest.raises(NoTransform) as raised:
        tree.lookup('camera', 'map', NOW + 3600 * 1000 * MS)
    assert raised.value.frame == 'pan'
    assert raised.value.apart_ns == 3600 * 1000 * MS - 100 * MS


def test_two_trees_are_named(tree: TransformTree) -> None:
    """With all that is known, and what would connect them."""
    tree.put_static('left', 'rig', Transform())
    with pytest.raises(NoTransform, match=(
        "'left' and 'map' are in two trees; publish where 'rig' lies in 'map', or in a frame that "
        'is connected to it; known are boat > imu, pan; map > boat; pan > camera; rig > left'
    )):
        tree.lookup('left', 'map', NOW)
    with pytest.raises(NoTransform, match='no transform at all has come'):
        TransformTree().lookup('left', 'map', NOW)


def test_what_holds_for_good_is_told_from_what_moves(tree: TransformTree) -> None:
    """An IMU must not ride on the pan/tilt."""
    assert tree.fixed('imu', 'map') == tree.lookup('imu', 'map', 1).transform
    with pytest.raises(NoTransform, match=(
        "'imu' is to be fixed in 'camera', and moves: 'pan' in 'boat' comes on /tf"
    )):
        tree.fixed('imu', 'camera')


def test_two_parents_are_refused_until_one_is_silent(tree: TransformTree) -> None:
    """Whatever hangs below it; what does not goes on."""
    tree.put('pan', 'mast', turned(0.3), NOW + 95 * MS)
    with pytest.raises(NoTransform, match="'pan' has two parents, 'boat' and 'mast'"):
        tree.lookup('camera', 'map', NOW + 95 * MS)
    assert tree.lookup('imu', 'map', NOW)
    tree.put('pan', 'boat', turned(0.4), NOW + 2096 * MS)
    tree.put('pan', 'boat', turned(0.4), NOW + 2196 * MS)
    assert tree.lookup('camera', 'map', NOW + 2100 * MS)


def test_one_parent_that_was_named_for_good_stays(tree: TransformTree) -> None:
    """Nobody takes it back."""
    tree.put_static('pan', 'mast', Transform())
    for step in range(300):
        tree.put('pan', 'boat', turned(0.0), NOW + (200 + 10 * step) * MS)
    with pytest.raises(NoTransform, match='two parents'):
        tree.lookup('camera', 'map', NOW + 3000 * MS)


def test_with_and_without_a_time_is_refused(tree: TransformTree) -> None:
    """Two nodes publish it, one on each topic."""
    tree.put_static('pan', 'boat', Transform())
    with pytest.raises(NoTransform, match='on /tf and on /tf_static'):
        tree.lookup('camera', 'map', NOW)


@pytest.mark.parametrize('frame, parent', [('map', 'camera'), ('boat', 'pan'), ('map', 'map')])
def test_a_circle_is_refused(frame: str, parent: str, tree: TransformTree) -> None:
    """And what was known stays."""
    for put in (
        lambda: tree.put_static(frame, parent, Transform()),
        lambda: tree.put(frame, parent, Transform(), NOW),
    ):
        with pytest.raises(TransformError, match='closes a circle'):
            put()
    assert tree.lookup('camera', 'map', NOW)


@pytest.mark.parametrize('frame, parent, transform, stamp_ns, words', [
    ('', 'boat', Transform(), NOW, 'the name of a frame is empty'),
    ('pan', '/boat', Transform(), NOW, "'/boat' begins with /"),
    ('pan', 'boat', Transform((np.nan, 0.0, 0.0)), NOW, 'must be finite'),
    ('pan', 'boat', Transform(rotation=(0.0, 0.0, 0.0, 2.0)), NOW, 'must have the length 1'),
    ('pan', 'boat', Transform(), 0, 'it has no stamp'),
    ('pan', 'boat', turned(1.0), NOW, 'there is another one with the stamp .* two nodes'),
])
def test_what_cannot_be_is_refused(
    frame: str, parent: str, transform: Transform, stamp_ns: int, words: str, tree: TransformTree
) -> None:
    """And nothing of it is kept."""
    before = tree.lookup('camera', 'map', NOW)
    with pytest.raises(TransformError, match=words):
        tree.put(frame, parent, transform, stamp_ns)
    assert tree.lookup('camera', 'map', NOW) == before
    assert tree.frames == ['boat', 'camera', 'imu', 'map', 'pan']


def test_over_a_gap_nothing_is_told(tree: TransformTree) -> None:
    """A pan/tilt may have been anywhere meanwhile."""
    tree.put('pan', 'boat', turned(0.5), NOW + 400 * MS)
    with pytest.raises(NoTransform, match=(
        "transforms of 'pan' in 'boat' are 0.300 s apart, and may be 0.2 s"
    )):
        tree.lookup('camera', 'map', NOW + 200 * MS)


def test_stamps_that_jump_back_begin_afresh(tree: TransformTree) -> None:
    """A bag that is played again; and a clock that was set back is told by `forget`."""
    jump = 60 * 1000 * MS
    assert tree.put('pan', 'boat', turned(0.2), NOW - jump) == pytest.approx(60.1)
    assert tree.lookup('pan', 'boat', NOW - jump).transform == turned(0.2)
    with pytest.raises(NoTransform, match='newest'):
        tree.lookup('pan', 'boat', NOW)
    tree.forget(NOW - jump - 1)
    with pytest.raises(NoTransform, match="no transform of 'pan' in 'boat' has come"):
        tree.lookup('camera', 'boat', NOW - jump)
    assert tree.lookup('imu', 'map', NOW)


def test_memory_is_bounded(tree: TransformTree) -> None:
    """In time, in frames and in parents, whatever comes."""
    for step in range(300):
        tree.put('pan', 'boat', turned(0.0), NOW + 10 * MS * (11 + step))
    with pytest.raises(NoTransform, match='oldest transform'):
        tree.lookup('pan', 'boat', NOW + 500 * MS)
    for number in range(MOST_PARENTS - 1):
        tree.put_static('pan', f'boat{number}', Transform())
    with pytest.raises(TransformError, match=f"'pan' has {MOST_PARENTS} parents"):
        tree.put_static('pan', 'boat9', Transform())
    with pytest.raises(TransformError, match=f'there are {MOST_FRAMES} frames'):
        for number in range(MOST_FRAMES):
            tree.put_static(f'frame{number}', 'map', Transform())
