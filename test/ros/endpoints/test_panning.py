"""Rays and angles that come while a pan/tilt turns."""

from __future__ import annotations

from threading import Event, Thread

from blob_tracker.ros.endpoints.panning import JointSeries, live_panning
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.stamp import from_ns
from blob_tracker.ros.messages.target import ray_message
from blob_tracker.types import Bearing
from geometry_msgs.msg import PoseWithCovarianceStamped
import numpy as np
import pytest
from sensor_msgs.msg import JointState
from support.processes import probe

MS = 1_000_000


def states(stamp_ns: int, names: list[str], angles: list[float]) -> JointState:
    """Return a message."""
    message = JointState(name=names, position=angles)
    message.header.stamp = from_ns(stamp_ns)
    return message


def test_angles_of_the_joints_that_are_asked_for() -> None:
    """One that is NaN is none; the names of all others are kept."""
    series = JointSeries(['pan', 'tilt'])
    series.take(states(MS, ['pan', 'wheel'], [0.1, 9.0]))
    series.take(states(2 * MS, ['tilt', 'pan'], [0.2, float('nan')]))
    assert series.angles == {'pan': {MS: 0.1}, 'tilt': {2 * MS: 0.2}}
    assert series.names == {'pan', 'tilt', 'wheel'}
    with pytest.raises(MessageError, match='has no position'):
        series.take(states(3 * MS, ['pan'], []))


def test_what_comes_live(domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both topics at once, for so long."""
    monkeypatch.setenv('ROS_DOMAIN_ID', str(domain))
    over = Event()
    with probe(domain) as node:
        rays = node.create_publisher(PoseWithCovarianceStamped, 'target/ray', 10)
        joints = node.create_publisher(JointState, 'joint_states', 10)

        def play() -> None:
            stamp_ns = 0
            while not over.wait(0.02):
                stamp_ns += MS
                rays.publish(ray_message(Bearing(1.0, 2.0, np.eye(2), stamp_ns), 'optical'))
                joints.publish(states(stamp_ns, ['pan', 'tilt'], [0.1, 0.2]))

        player = Thread(target=play)
        player.start()
        try:
            bearings, series = live_panning('target/ray', 'joint_states', ['pan', 'tilt'], 2.0)
        finally:
            over.set()
            player.join()
    assert len(bearings) > 3
    assert bearings[0].elevation == pytest.approx(2.0)
    assert all(len(series.angles[joint]) > 3 for joint in ('pan', 'tilt'))
