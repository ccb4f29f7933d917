"""<camera>/target/ray of two cameras -> target/point and target/pose."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
import sys
import time
from typing import Any, NamedTuple

from blob_tracker.nodes.interface.triangulator import CAMERAS, PARAMETERS
from blob_tracker.nodes.triangulator.camera_places import CameraPlaces
from blob_tracker.ros.diagnostics.clock_jumps import on_clock_jump
from blob_tracker.ros.diagnostics.connections import Connections
from blob_tracker.ros.diagnostics.health import ERROR, Health, WARN
from blob_tracker.ros.endpoints.names import check_light, target_topic
from blob_tracker.ros.endpoints.qos import publisher, RESULT, subscription
from blob_tracker.ros.errors import MessageError, ParameterError
from blob_tracker.ros.messages.position import point_message, pose_message
from blob_tracker.ros.messages.target import to_bearing
from blob_tracker.ros.parameters.declaration import declare, on_change
from blob_tracker.ros.parameters.values import about
from blob_tracker.ros.process import run
from blob_tracker.tracking import (
    Position, Sight, Simultaneous, triangulate, TriangulationError,
)
from blob_tracker.tracking.triangulation import check_bearing
from blob_tracker.transforms import NoTransform
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
MOST_HELD = 256  # rays that wait for their transforms; a second of the fastest camera


class _Held(NamedTuple):
    """A ray that waits for the transforms of its stamp, and when it came."""

    bearing: Bearing
    frame_id: str
    came: float  # monotonic time, s


@dataclass
class _Camera:
    """What has come of a camera."""

    topic: str
    came: float  # monotonic time, s
    age: float = 0.0  # of the last ray as it came, s
    held: deque[_Held] = field(default_factory=deque)


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
        self._cameras: dict[str, _Camera] = {}
        self._places = CameraPlaces(self, self._health, self._release)
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
        change_places = self._places.change(values)

        def use() -> None:
            change_places()
            self._frame_id, self._patience = values['frame_id'], values['tf_patience']
            self._gate_sigma = values['gate']
            self._pairing.max_interval = values['max_interval']
            self._pairing.acceleration = values['acceleration']

        return use

    def _forget(self, after_ns: int) -> None:
        """Forget the rays and transforms that have a later stamp, ns."""
        self._pairing.forget(after_ns)
        self._places.forget(after_ns)
        for camera in self._cameras.values():
            camera.held = deque(each for each in camera.held if each.bearing.stamp_ns <= after_ns)

    def _take(self, name: str, message: PoseWithCovarianceStamped) -> None:
        """Take a ray of a camera, once it is known where that was; see `_release`."""
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
        camera.held.append(_Held(bearing, message.header.frame_id, camera.came))
        self._release()

    def _release(self) -> None:
        """Pair the rays that need not wait any longer; publish the positions that they give."""
        for name, camera in self._cameras.items():
            while camera.held:
                bearing, frame_id, came = camera.held[0]
                waited = time.monotonic() - came
                try:
                    pose = self._places.pose(name, frame_id, bearing.stamp_ns)
                except NoTransform as gap:
                    if (
                        gap.may_come and waited < self._patience and len(camera.held) <= MOST_HELD
                    ):
                        break
                    camera.held.popleft()
                    self._health.count('rays without a transform')
                    self._health.fault(
                        WARN, f'{camera.topic}: ray left out: {self._places.explain(gap)}'
                    )
                    continue
                camera.held.popleft()
                self._places.waited = max(self._places.waited, waited)
                self._pair(name, Sight(bearing, pose))

    def _pair(self, name: str, sight: Sight) -> None:
        """Publish the positions for which a ray of a camera was missing."""
        take = self._pairing.first if name == CAMERAS[0] else self._pairing.second
        try:
            pairs = take(sight)
        except ValueError as error:
            self._health.fault(WARN, f'{self._cameras[name].topic}: {error}')
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

    def _triangulate(self, pair: tuple[Sight, Sight]) -> None:
        """Publish where the rays meet, or nothing at all."""
        if self._at_one_place():  # which is said each second
            return
        try:
            position = triangulate(
                [each.bearing for each in pair], [each.pose for each in pair],
                gate_sigma=self._gate_sigma,
            )
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
        poses = self._places.last()
        if len(poses) < len(CAMERAS):
            return False
        first, second = poses
        return float(np.linalg.norm(first.position - second.position)) < LEAST_BASELINE_M

    def _check_cameras(self) -> None:
        """Report cameras at one place, one that is silent, and rays that come in vain."""
        self._release()
        if self._at_one_place():
            self._health.fault(
                ERROR,
                'both cameras are at the same place; set first.x, first.y, first.z and second.x, '
                'second.y, second.z to where they are in frame_id, or use_tf where TF has them',
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
        self._places.describe()
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
