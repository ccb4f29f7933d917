"""Simulator, pipeline and the example servo in real time: the pan/tilt holds the light."""

from __future__ import annotations

from contextlib import ExitStack
from math import nan
from pathlib import Path
import sys

from blob_tracker.ros.endpoints.qos import RESULT
from blob_tracker.simulation.pan_tilt import Joints
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Vector3Stamped
import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import Imu, JointState
from support.processes import Probe, probe, Process, start

EXAMPLE = Path(__file__).parents[2] / 'examples' / 'servo_client.py'
RIDE = {
    'source': 'simulator', 'platform': 'sea', 'pan_tilt': True, 'width': 320, 'height': 240,
    'joints__pan': 'pan', 'joints__tilt': 'tilt', 'imu__enabled': True,
    'follow_prediction': True,
    # Half an interval of the predictions is the mean time that one of them is acted on.
    'servo_delay': Joints().delay + Joints().lag + 0.005,
}
ENOUGH = 300  # truths: ten seconds at 60 frames a second, of which every other one is lit


def pointing(node: Probe, truths: list[Vector3Stamped]) -> NDArray[np.float64]:
    """Return how far the camera points beside the light from now on, mrad."""
    truths.clear()
    node.spin_until(lambda: len(truths) >= ENOUGH)
    return np.array([np.hypot(each.vector.x, each.vector.y) for each in truths])


def test_the_servo_holds_the_light(domain: int) -> None:
    """In the median ten times better than a camera that is fixed to the boat."""
    with probe(domain) as node, ExitStack() as stack:
        truths = node.record(Vector3Stamped, 'simulator/truth/bearing')
        states = node.record(JointState, 'joint_states', 1000)
        imus = node.record(Imu, 'imu', 1000)
        diagnostics = node.record(DiagnosticArray, '/diagnostics', 1000)
        pipeline = stack.enter_context(start('pipeline', domain, **RIDE))
        fixed = pointing(node, truths)
        assert {tuple(each.name) for each in states} == {('pan', 'tilt')}
        assert not np.any([each.position for each in states])
        assert np.std([each.angular_velocity.y for each in imus]) > 0.01  # rad/s; 0.05 or so

        servo = stack.enter_context(Process(
            [sys.executable, str(EXAMPLE), '--ros-args', '-p', 'predicted:=true'], domain
        ))
        node.spin_until(lambda: np.any(states[-1].position))
        node.spin(2.0)
        held = pointing(node, truths)
        # Real time on a machine that is busy with other tests: what late commands cost is in the
        # tail, of which nothing is asked. It was 0.5 of 24 mrad on two cores, 2.2 without the IMU
        # and 17 with target/bearing alone: a tenth tells the prediction from both.
        assert np.median(held) < 0.1 * np.median(fixed)
        # The frames come in the callback that publishes the joints: with bearings that do not wait
        # for them the mean was 6.4, as of a joint error eight times the bearing's. 2 is right at
        # most: process noise is chosen for a light that moves, and this one does not.
        values = {
            each.key: each.value for array in diagnostics for each in array.status[0].values
            if array.status[0].name == '/tracker: tracking'
        }
        assert float(values['innovation squared']) < 4.0
        assert pipeline.running and servo.running


def test_what_is_no_command_moves_nothing(domain: int) -> None:
    """A joint that is not there, an angle too few, a NaN: each is named."""
    with probe(domain) as node, start(
        'simulator', domain, pan_tilt=True, width=160, height=120
    ) as simulator:
        states = node.record(JointState, 'joint_states', 1000)
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        commands = node.create_publisher(JointState, 'joint_command', RESULT)
        node.spin_until(commands.get_subscription_count)
        for names, angles, sentence in (
            (['elbow'], [1.0], 'it is not of the joints pan and tilt'),
            (['pan', 'tilt'], [1.0], "the joint 'tilt' has no position"),
            (['pan', 'tilt'], [nan, 0.1], 'both must be finite'),
        ):
            def said() -> bool:
                commands.publish(JointState(name=names, position=angles))
                node.spin(0.2)
                return any(sentence in each.status[0].message for each in diagnostics)

            node.spin_until(said)
        assert states and not np.any([each.position for each in states])
        commands.publish(JointState(name=['tilt', 'pan'], position=[0.02, -0.03]))
        node.spin_until(lambda: np.allclose(states[-1].position, [-0.03, 0.02], atol=1e-4))
        assert simulator.running
