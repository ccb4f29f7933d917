"""What a change of the parameters leaves of the samples."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from threading import Lock
from types import SimpleNamespace
from typing import Any

from blob_tracker.nodes.interface.optical_frame import PITCH, ROLL, YAW
from blob_tracker.nodes.tracker.platform import Platform
from blob_tracker.ros.diagnostics.health import Health
from blob_tracker.ros.diagnostics.joint_news import SILENCE_NS
from blob_tracker.ros.messages.stamp import from_ns
from blob_tracker.tracking import PlatformGap
import numpy as np
import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from sensor_msgs.msg import Imu
from support.transforms import transform

MS = 1_000_000
BEFORE = {
    'imu.enabled': True, 'imu.frame_id': 'imu_link', 'imu.roll': 0.0, 'imu.pitch': 0.0,
    'imu.yaw': 0.0, 'imu.stamp_offset': 0.0, 'imu.bias_x': 0.0, 'imu.bias_y': 0.0,
    'imu.bias_z': 0.0, 'joints.pan': 'pan', 'joints.tilt': 'tilt', 'joints.pan_reversed': False,
    'joints.tilt_reversed': False, 'joints.sigma': 0.03, 'joints.frame_id': 'base',
    'imu.use_tf': False, 'joints.use_tf': False, 'tf_patience': 0.1,
}


@pytest.fixture
def platform(domain: int) -> Iterator[Platform]:
    """Make one that reads an IMU and two joints, of which samples have come."""
    context = Context()
    rclpy.init(args=[], context=context, domain_id=domain)
    node = Node('own', context=context)
    try:
        made = Platform(node, Health(node, ''), Lock(), lambda: None)
        assert made.change(BEFORE)()
        made.rates.push(1, [0.0, 0.0, 0.0])
        made.angles.push(1, 0.0, 0.0)
        yield made
    finally:
        node.destroy_node()
        rclpy.try_shutdown(context=context)


@pytest.mark.parametrize('change, rates_stay, angles_stay', [
    ({}, True, True),
    ({'joints.sigma': 0.5}, True, True),
    ({'joints.frame_id': 'mast'}, True, True),
    ({'imu.frame_id': 'other'}, True, True),
    ({'imu.roll': 0.1}, False, True),
    ({'imu.enabled': False}, False, True),
    ({'joints.pan_reversed': True}, True, False),
    ({'joints.tilt': ''}, True, False),
    ({'joints.pan': '', 'joints.tilt': ''}, True, False),
])
def test_samples_stay_where_they_still_mean_the_same(
    change: dict[str, Any], rates_stay: bool, angles_stay: bool, platform: Platform
) -> None:
    """Those of the gyro whatever is said of the joints, and the other way round."""
    rates, angles = platform.rates, platform.angles
    afresh = platform.change({**BEFORE, **change})()
    assert afresh is not (rates_stay and angles_stay)
    assert (platform.rates is rates) is rates_stay
    assert (platform.angles is angles) is angles_stay


def test_how_wrong_the_joints_are_is_set_at_once(platform: Platform) -> None:
    """In rad, of all angles from now on; and the name of their frame."""
    platform.change({**BEFORE, 'joints.sigma': 0.5, 'joints.frame_id': 'mast'})()
    assert platform.angles.sigma == pytest.approx(5e-4)
    assert platform.frame_id == 'mast'
    platform.change({**BEFORE, 'joints.pan': '', 'joints.tilt': ''})()
    assert platform.frame_id == ''


def test_what_the_imu_is_turned_by_changes_nothing_while_it_is_not_read(
    platform: Platform
) -> None:
    """No track begins afresh for that."""
    without = {**BEFORE, 'imu.enabled': False}
    assert platform.change(without)()
    assert not platform.change({**without, 'imu.roll': 0.1})()
    assert platform.change({**BEFORE, 'imu.roll': 0.1})()


def test_angles_are_awaited_until_one_is_as_new(platform: Platform) -> None:
    """Where no joints are read there is nothing to wait for."""
    assert not platform.awaits(1)
    assert platform.awaits(2)
    platform.reset()
    assert platform.awaits(1)
    platform.change({**BEFORE, 'joints.pan': '', 'joints.tilt': ''})()
    assert not platform.awaits(2)


def sample(platform: Platform, milliseconds: int, *rate: float) -> None:
    """Have a sample of the IMU come, rad/s."""
    message = Imu()
    message.header.stamp = from_ns(milliseconds * MS)
    message.header.frame_id = 'xsens'
    vector = message.angular_velocity
    vector.x, vector.y, vector.z = rate
    platform._take_imu(message)


def test_the_mount_of_the_imu_is_that_of_tf(tf2_messages: None, platform: Platform) -> None:
    """Of the frame of its messages against that of the rays; other samples go with another one."""
    platform.change({
        **BEFORE, 'joints.pan': '', 'joints.tilt': '', 'imu.use_tf': True, 'imu.roll': ROLL,
        'imu.pitch': PITCH, 'imu.yaw': YAW,
    })()
    tree = platform._transforms._tree
    tree.put_static('optical', 'xsens', transform(1.0, 2.0, 3.0, yaw=pi / 2))
    sample(platform, 1000, 1.0, 2.0, 3.0)
    assert platform.rates.newest_ns is None  # no ray has told what the camera is called
    platform.looks_through('optical', 1000 * MS)
    sample(platform, 1001, 1.0, 2.0, 3.0), sample(platform, 1002, 1.0, 2.0, 3.0)
    # The optical x axis is the IMU's y axis.
    np.testing.assert_allclose(platform.rates.rate_at(1001 * MS), [2.0, -1.0, 3.0], atol=1e-12)
    tree.put_static('optical', 'xsens', transform())
    sample(platform, 1003, 1.0, 2.0, 3.0)
    np.testing.assert_allclose(platform.rates.rate_at(1003 * MS), [1.0, 2.0, 3.0])
    with pytest.raises(PlatformGap):
        platform.rates.rate_at(1001 * MS)


def test_a_mount_that_is_given_is_used(tf2_messages: None, platform: Platform) -> None:
    """And imu.frame_id counts with it."""
    platform.change({
        **BEFORE, 'imu.use_tf': True, 'imu.frame_id': 'xsens', 'imu.roll': 0.0,
    })()
    sample(platform, 1000, 1.0, 2.0, 3.0), sample(platform, 1001, 1.0, 2.0, 3.0)
    np.testing.assert_allclose(platform.rates.rate_at(1000 * MS), [1.0, 2.0, 3.0])


def test_tf_is_in_place_of_the_joints(tf2_messages: None, platform: Platform) -> None:
    """Where none is named; its base is the frame of the predictions."""
    without = {**BEFORE, 'joints.pan': '', 'joints.tilt': '', 'joints.use_tf': True}
    assert platform.change(without)()
    assert platform.angles is None
    assert platform.pan_tilt is platform.turns
    assert (platform.frame_id, platform.patience_ns) == ('base', 100 * MS)
    turns = platform.turns
    platform.change({**without, 'tf_patience': 0.5, 'joints.sigma': 0.5})()
    assert platform.turns is turns
    assert (platform.patience_ns, turns.sigma) == (500 * MS, pytest.approx(5e-4))
    assert platform.change({**without, 'joints.frame_id': 'mast'})()
    assert platform.turns is not turns
    platform.looks_through('optical', 1)
    assert platform.awaits(1)
    platform._transforms._tree.put_static('optical', 'mast', transform())
    assert not platform.awaits(1)
    assert platform.change(BEFORE)()
    assert platform.pan_tilt is platform.angles is not None


@pytest.mark.parametrize('starting', [True, False])
def test_joints_are_missed_once_they_could_have_come(
    starting: bool, domain: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither while the others start, nor as simulated time leaps from 0 to that of a bag."""
    context = Context()
    rclpy.init(args=[], context=context, domain_id=domain)
    node = Node('own', context=context)
    faults: list[str] = []
    health = SimpleNamespace(starting=starting, fault=lambda level, words: faults.append(words))
    now_ns = 0
    monkeypatch.setattr(Platform, '_now_ns', lambda self: now_ns)
    try:
        made = Platform(node, health, Lock(), lambda: None)  # type: ignore[arg-type]
        made.change(BEFORE)()
        for now_ns in (0, 10**18):
            made.describe()
            assert not faults
        now_ns += SILENCE_NS + 1
        made.describe()
        assert len(faults) == (not starting)
    finally:
        node.destroy_node()
        rclpy.try_shutdown(context=context)
