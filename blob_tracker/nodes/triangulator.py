"""<camera>/target/ray of two cameras -> target/point and target/pose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
import sys
import time
from typing import Any

from blob_tracker.nodes.interface.triangulator import CAMERAS, PARAMETERS
from blob_tracker.ros.diagnostics.clock_jumps import on_clock_jump
from blob_tracker.ros.diagnostics.connections import Connections
from blob_tracker.ros.diagnostics.health import ERROR, Health, WARN
from blob_tracker.ros.endpoints.names import check_light, target_topic
from blob_tracker.ros.endpoints.qos import publisher, RESULT, subscription
from blob_tracker.ros.errors import MessageError, ParameterError
from blob_tracker.ros.messages.imu import turn_of
from blob_tracker.ros.messages.position import point_message, pose_message
from blob_tracker.ros.messages.target import to_bearing
from blob_tracker.ros.parameters.declaration import declare, on_change
from blob_tracker.ros.parameters.values import about
from blob_tracker.ros.process import run
from blob_tracker.tracking import (
    CameraPose, Position, Simultaneous, triangulate, TriangulationError,
)
from blob_tracker.tracking.triangulation import check_bearing
from blob_tracker.types import Bearing
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped
import numpy as np
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.validate_topic_name import validate_topic_name

SILENCE_S = 2.0  # s of wall time without a ray, while the other camera has some
TOGETHER_S = 0.1  # s of wall time within which the ages of two rays are compared
APART_S = 1.0  # s by which they may differ: no camera is so much later than another
LEAST_BASELINE_M = 1e-9  # m


@dataclass
class _Camera:
    """What has come of a camera."""

    topic: str
    came: float  # monotonic time, s
    age: float = 0.0  # of the last ray as it came, s


class TriangulatorNode(Node):
    """See the module's first line; the work is that of the room `tracking`."""

    def __init__(self) -> None:
        super().__init__('triangulator')
        values = declare(self, PARAMETERS)
        self._health = Health(
            self,
            'no ray arrives; are two locators running, in the namespaces of first.namespace and '
            'second.namespace?',
            describe=self._describe,
        )
        self._connections = Connections(self, self._health)
        self._position: Position | None = None
        self._pairing = Simultaneous(values['max_interval'], values['acceleration'])
        self._skipped = 0  # when it was last told
        self._change(values)()
        on_change(self, PARAMETERS, self._change)
        light = values['light']
        if light:
            with about('light'):
                check_light(light)
        target = target_topic(light)
        self._points = publisher(self, PointStamped, f'{target}/point', RESULT)
        self._poses = publisher(self, PoseWithCovarianceStamped, f'{target}/pose', RESULT)
        self._cameras: dict[str, _Camera] = {}
        for name in CAMERAS:
            topic = f'{values[f"{name}.namespace"]}/{target}/ray'
            try:
                validate_topic_name(topic)
            except InvalidTopicNameException as error:
                raise ParameterError(f"parameter '{name}.namespace': {error}") from None
            subscription(
                self, PoseWithCovarianceStamped, topic, partial(self._take, name), RESULT
            )
            self._cameras[name] = _Camera(self.resolve_topic_name(topic), time.monotonic())
        first, second = (self._cameras[name].topic for name in CAMERAS)
        if first == second:
            raise ParameterError(
                f'first.namespace and second.namespace are both that of {first}; each camera has '
                'a namespace of its own'
            )
        self._health.watch(self._check_cameras)
        self._clock_jumps = on_clock_jump(self, self._health, self._forget)

    def _change(self, values: dict[str, Any]) -> Callable[[], None]:
        """Build what these parameters ask for; return what puts it into effect."""
        poses = [
            CameraPose(
                np.array([values[f'{name}.{axis}'] for axis in 'xyz']),
                turn_of(*(values[f'{name}.{angle}'] for angle in ('roll', 'pitch', 'yaw'))),
                position_sigma=values[f'{name}.position_sigma'],
                rotation_sigma=values[f'{name}.rotation_sigma'],
            )
            for name in CAMERAS
        ]

        def use() -> None:
            self._camera_poses, self._frame_id = poses, values['frame_id']
            self._gate_sigma = values['gate']
            self._pairing.max_interval = values['max_interval']
            self._pairing.acceleration = values['acceleration']

        return use

    def _forget(self, after_ns: int) -> None:
        """Forget the rays that have a later stamp, ns."""
        self._pairing.forget(after_ns)

    def _take(self, name: str, message: PoseWithCovarianceStamped) -> None:
        """Take a ray of a camera; publish the positions for which it was missing."""
        camera = self._cameras[name]
        try:
            bearing = to_bearing(message)
            check_bearing(bearing)
        except (MessageError, TriangulationError) as error:
            self._health.fault(ERROR, f'{camera.topic}: {error}')
            return
        self._health.arrived(bearing.stamp_ns)
        self._health.count(f'rays of the {name} camera')
        camera.came = time.monotonic()
        camera.age = 1e-9 * (self.get_clock().now().nanoseconds - bearing.stamp_ns)
        if self._clocks_differ():
            self._pairing.forget(-1)
            return
        try:
            take = self._pairing.first if name == CAMERAS[0] else self._pairing.second
            pairs = take(bearing)
        except ValueError as error:
            self._health.fault(WARN, f'{camera.topic}: {error}')
            return
        for pair in pairs:
            self._triangulate(pair)

    def _clocks_differ(self) -> bool:
        """Tell, and say, whether the rays that come together have stamps of different clocks."""
        first, second = (self._cameras[name] for name in CAMERAS)
        apart = second.age - first.age
        if abs(first.came - second.came) > TOGETHER_S or abs(apart) <= APART_S:
            return False
        late, early = (second, first) if apart > 0.0 else (first, second)
        self._health.fault(
            ERROR,
            f'the rays on {late.topic} are {abs(apart):.1f} s older as they come than those on '
            f'{early.topic}: they have stamps of different clocks; set both machines by NTP or '
            'PTP, and use_sim_time alike',
        )
        return True

    def _triangulate(self, pair: tuple[Bearing, Bearing]) -> None:
        """Publish where the rays meet, or nothing at all."""
        if self._at_one_place():  # which is said each second
            return
        try:
            position = triangulate(pair, self._camera_poses, gate_sigma=self._gate_sigma)
        except TriangulationError as error:
            self._health.fault(WARN, f'no position: {error}')
            self._health.count('pairs refused')
            self._health.show('last refusal', error)
            return
        self._points.publish(point_message(position, self._frame_id))
        self._poses.publish(pose_message(position, self._frame_id))
        self._health.left(position.stamp_ns)
        self._health.count('positions')
        self._health.ok('target placed')
        self._position = position

    def _at_one_place(self) -> bool:
        """Tell whether no one has said yet where the cameras are."""
        first, second = self._camera_poses
        return float(np.linalg.norm(first.position - second.position)) < LEAST_BASELINE_M

    def _check_cameras(self) -> None:
        """Report cameras at one place, one that is silent, and rays that come in vain."""
        if self._at_one_place():
            self._health.fault(
                ERROR,
                'both cameras are at the same place; set first.x, first.y, first.z and second.x, '
                'second.y, second.z to where they are in frame_id',
            )
        now = time.monotonic()
        silent = [each for each in self._cameras.values() if now - each.came > SILENCE_S]
        if len(silent) == 1 and not self._health.starting:
            heard = next(each for each in self._cameras.values() if each not in silent)
            self._health.fault(
                WARN,
                f'{silent[0].topic} is silent and {heard.topic} is not: there is no position; '
                'does that camera see the light, and is the name right?',
            )
        skipped, self._skipped = self._pairing.skipped - self._skipped, self._pairing.skipped
        if skipped and not silent:
            self._health.fault(
                WARN,
                f'{skipped} rays of the first camera had none of the second near enough, last '
                f'{self._pairing.interval:.3f} s; raise max_interval, or name the camera with '
                'fewer rays first',
            )

    def _describe(self) -> None:
        """Show in the diagnostics what was found last."""
        self._health.show(
            'time between the rays that are interpolated (s)', f'{self._pairing.interval:.4f}'
        )
        position = self._position
        if position is None:
            return
        deviations = np.sqrt(position.covariance.diagonal())
        systematic = np.sqrt(position.systematic.diagonal())
        for axis, place, sigma, lasting in zip(
            'xyz', position.position, deviations, systematic, strict=True
        ):
            self._health.show(f'{axis} (m)', f'{place:.4f} +- {sigma:.4f}')
            self._health.show(f'of it by the camera poses, {axis} (m)', f'{lasting:.4f}')
        self._health.show('chi-square', f'{position.chi2:.2f}')


def main() -> None:
    """Run the node."""
    sys.exit(run(lambda: [TriangulatorNode()]))
