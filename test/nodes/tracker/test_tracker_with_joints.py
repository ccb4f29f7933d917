"""The tracker as a real process that hears how the pan/tilt head stands."""

from __future__ import annotations

from math import atan2, cos, hypot, inf, nan, radians, sin

from blob_tracker.ros.endpoints.qos import RESULT
from blob_tracker.ros.messages.stamp import from_ns, to_ns
from blob_tracker.ros.messages.track import to_track
from blob_tracker.tracking import PanTiltAngles, Tracker
import numpy as np
import pytest
from sensor_msgs.msg import JointState
from support.played_bearings import FRAME, LATENCY, MAX_SIGMA, MS, path, Played, playing
from support.processes import probe

# The direction of azimuth 500 and elevation 50 mrad.
AT_REST = np.array([sin(0.5) * cos(0.05), -sin(0.05), cos(0.5) * cos(0.05)])


def _joints(played: Played, names: list[str], positions: list[float]) -> JointState:
    message = JointState(name=names, position=positions)
    message.header.stamp = from_ns(played.now_ns)
    return message


def test_with_joints_the_prediction_is_the_angle_to_command(domain: int) -> None:
    """A light at rest in the base, a camera that pans before it: x and y stay where they are."""
    angles = PanTiltAngles(sigma=3e-5)  # the default of joints.sigma
    tracker = Tracker(pan_tilt=angles, max_sigma=MAX_SIGMA)
    with playing(
        domain, joints__pan='pan', joints__tilt='tilt', joints__tilt_reversed=True,
        prediction_rate=0.0,
    ) as played:
        played.node.spin_until(played.joints.get_subscription_count)
        for count in range(40):
            played.tick(20 * MS)
            pan, tilt = 0.4 + 0.01 * count, 0.05
            names = ['wheel', 'tilt', 'pan']
            played.joints.publish(_joints(played, names, [nan, -tilt, pan]))
            angles.push(played.now_ns, pan, tilt)
            played.node.settle(0.01)
            if not count:
                continue  # between two places of the joints it is known where it looks
            x, y, z = angles.at(played.now_ns - 10 * MS).T @ AT_REST
            ray = played.message(
                1e3 * atan2(x, z), 1e3 * atan2(-y, hypot(x, z)), age=10 * MS
            )
            played.compare(ray, tracker)
        prediction = played.predictions[0]
        assert prediction.header.frame_id == 'base_optical_frame'
        assert prediction.vector.x == pytest.approx(500.0, abs=0.5)
        assert prediction.vector.y == pytest.approx(50.0, abs=0.5)
        assert played.tracks[-1].header.frame_id == 'optical'
        # As the camera sees it, the light goes left at the rate of the pan.
        assert to_track(played.tracks[-1]).rate[0] == pytest.approx(-500.0, abs=5.0)


def test_without_the_joints_nothing_is_predicted(domain: int) -> None:
    """Nobody knows where the camera looks: an error that says what would be right."""
    with playing(domain, joints__pan='pan', joints__tilt='tilt') as played:
        played.node.spin_until(played.joints.get_subscription_count)

        def bearings(count: int) -> None:
            for _ in range(count):
                played.tick(FRAME)
                played.rays.publish(played.message(*path(played.now_ns - LATENCY)))

        bearings(50)
        played.expect('start the driver of the pan/tilt, or remap joint_states')
        assert played.level('no angle of pan and tilt arrives on joint_states') == 2
        for message, sentence in (
            (_joints(played, ['left', 'right'], [0.0, 0.0]), 'it has left, right: set joints.pan'),
            (_joints(played, ['pan', 'tilt'], [0.0]), "the joint 'tilt' has no position"),
            (_joints(played, ['pan', 'tilt'], [0.0, inf]), 'tilt is inf rad; it must be finite'),
            (_joints(played, ['pan', 'tilt'], [nan, nan]), 'is NaN there: home the pan/tilt'),
        ):
            played.joints.publish(message)
            played.expect(sentence)
            bearings(3)
        assert not played.predictions
        assert all(each.data is False for each in played.tracked)
        for _ in range(30):
            played.tick(FRAME)
            played.joints.publish(_joints(played, ['pan', 'tilt'], [0.1, 0.0]))
            played.rays.publish(played.message(*path(played.now_ns - LATENCY)))
        played.expect_tracked(tracked=True)
        assert played.predictions[-1].vector.x == pytest.approx(
            100.0 + path(to_ns(played.predictions[-1].header.stamp))[0], abs=5.0
        )


def _one_a_message(played: Played, name: str, angle: float, stamped: bool = True) -> JointState:
    message = _joints(played, [name], [angle])
    if not stamped:
        message.header.stamp = from_ns(0)
    return message


@pytest.mark.parametrize('stamped', [True, False])
def test_joints_of_several_nodes_one_a_message(stamped: bool, domain: int) -> None:
    """Wheels from another node, NaN until the tilt has homed, and stamps of 0: it points right."""
    with (
        playing(domain, joints__pan='pan', joints__tilt='tilt') as played,
        probe(domain, 'base') as other,
    ):
        wheels = other.create_publisher(JointState, '/joint_states', RESULT)
        played.node.spin_until(played.joints.get_subscription_count)
        other.spin_until(wheels.get_subscription_count)
        for count in range(120):
            played.tick(10 * MS, 10 * MS)
            pan = 0.4 + 0.002 * count
            tilt = nan if count < 30 else 0.05
            wheels.publish(_one_a_message(played, 'left_wheel', 0.1 * count, stamped))
            played.joints.publish(_one_a_message(played, 'pan', pan, stamped))
            played.joints.publish(_one_a_message(played, 'tilt', tilt, stamped))
            played.node.settle(0.01)
            # Between the last two angles, of either joint.
            turned = PanTiltAngles()
            turned.push(0, pan - 0.001, 0.05)
            x, y, z = turned.at(0).T @ AT_REST
            played.rays.publish(
                played.message(1e3 * atan2(x, z), 1e3 * atan2(-y, hypot(x, z)), 0.1, age=5 * MS)
            )
            if count < 30:
                assert not played.predictions
        played.node.spin_until(lambda: bool(played.predictions))
        prediction = played.predictions[-1]
        assert prediction.vector.x == pytest.approx(500.0, abs=1.0)
        assert prediction.vector.y == pytest.approx(50.0, abs=1.0)
        played.node.spin_until(lambda: played.shown('state') == 'tracking')
        assert not played.said('publish')
        assert not played.said('set joints')
        if not stamped:
            played.node.spin_until(
                lambda: int(played.shown('joint_states without a stamp') or 0) >= 200
            )


def test_a_joint_that_two_nodes_publish_is_told(domain: int) -> None:
    """By the names of those that publish, of which one must go."""
    with (
        playing(domain, joints__pan='pan', joints__tilt='tilt') as played,
        probe(domain, 'second') as other,
    ):
        again = other.create_publisher(JointState, '/joint_states', RESULT)
        played.node.spin_until(played.joints.get_subscription_count)
        other.spin_until(again.get_subscription_count)
        sentence = "several nodes publish the joint 'pan' on /joint_states"

        def said() -> bool:
            played.tick(10 * MS, 10 * MS)
            played.joints.publish(_joints(played, ['pan', 'tilt'], [0.1, 0.0]))
            played.tick(10 * MS, 10 * MS)
            again.publish(_joints(played, ['pan'], [0.5]))
            return played.said(sentence)

        played.node.spin_until(said)
        assert played.said('of /probe, /second/probe let one do so')
        assert not played.said("the joint 'tilt' on")
        assert played.level(sentence) == 1


def test_joints_in_degrees_are_named(domain: int) -> None:
    """Before any of what else may make bearings leap."""
    with playing(domain, joints__pan='pan', joints__tilt='tilt') as played:
        played.node.spin_until(played.joints.get_subscription_count)
        turned = iter(range(10**6))

        def said() -> bool:
            degrees = 50.0 + 5.0 * sin(0.1 * next(turned))
            played.tick(20 * MS, 20 * MS)
            played.joints.publish(_joints(played, ['pan', 'tilt'], [degrees, 1.0]))
            played.node.spin(0.002)
            played.rays.publish(played.message(800.0 - 1e3 * radians(degrees), 0.0, age=0))
            return played.said('rad: is that in degrees? joint_states has rad; the joints are')

        played.node.spin_until(said)
        assert not played.said('tilt is 1.0 rad')
