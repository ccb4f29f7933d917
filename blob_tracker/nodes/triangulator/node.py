"""<camera>/target/ray of two cameras or more -> target/point and target/pose."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import combinations
import math
import sys
import time
from typing import Any, NamedTuple

from blob_tracker.kernel import Array
from blob_tracker.nodes.interface.triangulator import OWN, pose_of, pose_parameters
from blob_tracker.nodes.triangulator.camera_places import CameraPlaces
from blob_tracker.ros.diagnostics.clock_jumps import on_clock_jump
from blob_tracker.ros.diagnostics.connections import Connections
from blob_tracker.ros.diagnostics.health import ERROR, Health, WARN
from blob_tracker.ros.endpoints.names import check_light, target_topic
from blob_tracker.ros.endpoints.qos import publisher, RESULT, subscription
from blob_tracker.ros.errors import MessageError, ParameterError
from blob_tracker.ros.messages.position import point_message, pose_message
from blob_tracker.ros.messages.ray import of_another_camera, to_bearing
from blob_tracker.ros.parameters.declaration import declare, on_change, undeclared
from blob_tracker.ros.parameters.values import about, unknown
from blob_tracker.ros.process import run
from blob_tracker.tracking import (
    Instant, Position, Sight, Simultaneous, triangulate, TriangulationError,
)
from blob_tracker.tracking.triangulation import check_bearing, load_ahead
from blob_tracker.transforms import NoTransform
from blob_tracker.types import Bearing
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped
import numpy as np
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.validate_topic_name import validate_topic_name

SILENCE_S = 2.0  # s of wall time without a ray, while another camera has some
TOGETHER_S = 1.0  # s of wall time within which the ages of two rays are compared
APART_S = 1.0  # s by which they may differ: no camera is so much later than another
LEAST_BASELINE_M = 1e-9  # m
MOST_HELD = 256  # rays that wait for their transforms; a second of the fastest camera
LEAST_EIGENVALUE = -1e-6  # of a covariance, of the greatest: written with seven digits
FORMER = ('first', 'second')  # what the two cameras were called that there could be


class _Held(NamedTuple):
    """A ray that waits for the transforms of its stamp, and when it came."""

    bearing: Bearing
    frame_id: str
    came: float  # monotonic time, s


@dataclass
class _Camera:
    """What has come of a camera."""

    name: str
    topic: str
    came: float = -math.inf  # monotonic time, s
    age: float = math.nan  # of the last ray as it came, s
    frame_id: str = ''  # of the first ray
    held: deque[_Held] = field(default_factory=deque)


class TriangulatorNode(Node):
    """See the module's first line; the work is that of the room `tracking`."""

    def __init__(self) -> None:
        super().__init__('triangulator')
        values = declare(self, OWN, complete=False)
        names: list[str] = values['cameras']
        light = values['light']
        if light:
            with about('light'):
                check_light(light)
        target = target_topic(light)
        self._cameras = [
            _Camera(name, self.resolve_topic_name(topic))
            for name, topic in _topics(names, target).items()
        ]
        parameters = (*OWN, *pose_parameters(names))
        values |= declare(self, parameters[len(OWN):], complete=False)
        for name in undeclared(self):
            raise _unknown(name, values, names)
        self._health = Health(
            self,
            f'no ray arrives of {", ".join(names)}; is there a locator in the namespace of each?',
            describe=self._describe,
        )
        self._connections = Connections(self, self._health)
        self._places = CameraPlaces(self, self._health, names, self._release)
        self._position: Position | None = None
        self._seen_by = ''
        self._pairing = Simultaneous(len(names), values['max_interval'], values['acceleration'])
        self._skipped = self._unseen = 0  # when they were last told
        self._late = list(self._pairing.late)
        self._change(values)()
        on_change(self, parameters, self._change)
        self._points = publisher(self, PointStamped, f'{target}/point', RESULT)
        self._poses = publisher(self, PoseWithCovarianceStamped, f'{target}/pose', RESULT)
        load_ahead()  # rays that wait for it would be old when they are taken
        for number, camera in enumerate(self._cameras):
            subscription(
                self, PoseWithCovarianceStamped, camera.topic, partial(self._take, number), RESULT
            )
        self._health.watch(self._check_cameras)
        self._clock_jumps = on_clock_jump(self, self._health, self._forget)

    def _change(self, values: dict[str, Any]) -> Callable[[], None]:
        """Build what these parameters ask for; return what puts it into effect."""
        change_places = self._places.change(values)
        shared = _shared(values['pose_covariance'], len(self._cameras))

        def use() -> None:
            change_places()
            self._shared = shared
            self._frame_id, self._patience = values['frame_id'], values['tf_patience']
            self._gate_sigma = values['gate']
            self._pairing.max_interval = values['max_interval']
            self._pairing.acceleration = values['acceleration']

        return use

    def _forget(self, after_ns: int) -> None:
        """Forget the rays and transforms that have a later stamp, ns."""
        self._pairing.forget(after_ns)
        self._places.forget(after_ns)
        for camera in self._cameras:
            camera.age = math.nan
            camera.held = deque(each for each in camera.held if each.bearing.stamp_ns <= after_ns)

    def _take(self, number: int, message: PoseWithCovarianceStamped) -> None:
        """Take a ray of a camera, once it is known where that was; see `_release`."""
        camera = self._cameras[number]
        try:
            bearing = to_bearing(message)
            check_bearing(bearing)
        except (MessageError, TriangulationError) as error:
            self._health.fault(ERROR, f'{camera.topic}: {error}')
            return
        frame_id = message.header.frame_id
        # TF places a ray by its own frame, whatever the others were in.
        if self._places.is_fixed(camera.name) and not self._is_of(camera, frame_id):
            return
        self._health.arrived(bearing.stamp_ns)
        self._health.count(f'rays of {camera.name}')
        camera.came = time.monotonic()
        camera.age = 1e-9 * (self.get_clock().now().nanoseconds - bearing.stamp_ns)
        if self._clock_differs(camera):
            self._pairing.leave_out(number)
            camera.held.clear()
            return
        if camera.name in self._places.unknown:  # which is said each second
            return
        camera.held.append(_Held(bearing, frame_id, camera.came))
        self._release()

    def _release(self) -> None:
        """Pair the rays that need not wait any longer; publish the positions that they give."""
        for number, camera in enumerate(self._cameras):
            while camera.held:
                bearing, frame_id, came = camera.held[0]
                waited = time.monotonic() - came
                try:
                    pose = self._places.pose(camera.name, frame_id, bearing.stamp_ns)
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
                self._pair(number, Sight(bearing, pose))

    def _pair(self, number: int, sight: Sight) -> None:
        """Publish the positions for which a ray of a camera was missing."""
        try:
            complete = self._pairing.take(number, sight)
        except ValueError as error:
            self._health.fault(WARN, f'{self._cameras[number].topic}: {error}')
            return
        for seen in complete:
            self._triangulate(seen)

    def _is_of(self, camera: _Camera, frame_id: str) -> bool:
        """Tell whether a ray is in the frame of the camera's first one; say so where not."""
        camera.frame_id = camera.frame_id or frame_id
        if frame_id == camera.frame_id:
            return True
        complaint = of_another_camera('the ray', frame_id, camera.frame_id)
        self._health.fault(ERROR, f'{camera.topic}: {complaint}')
        return False

    def _clock_differs(self, camera: _Camera) -> bool:
        """Tell, and say, whether a camera's stamps are of another clock than most others'."""
        others = [
            each for each in self._cameras
            if each is not camera and camera.came - each.came < TOGETHER_S
            and not math.isnan(each.age)
        ]
        apart = [each for each in others if abs(each.age - camera.age) > APART_S]
        if 2 * len(apart) <= len(others):
            return False
        by = apart[0].age - camera.age
        late, early = (apart, [camera]) if by > 0.0 else ([camera], apart)
        self._health.fault(
            ERROR,
            f'the rays on {_topics_of(late)} are {abs(by):.1f} s older as they come than those on '
            f'{_topics_of(early)}: they have stamps of different clocks; set all machines by NTP '
            'or PTP, and use_sim_time alike'
            + (f'; {camera.topic} is left out' if len(others) > 1 else ''),
        )
        return True

    def _triangulate(self, seen: Instant) -> None:
        """Publish where the rays meet, or nothing at all."""
        if self._at_one_place():  # which is said each second
            return
        names = [self._cameras[number].name for number in seen.cameras]
        try:
            position = triangulate(
                [each.bearing for each in seen.sights], [each.pose for each in seen.sights],
                gate_sigma=self._gate_sigma, names=names,
                shared=_part(self._shared, seen.cameras), strayed=seen.strayed,
            )
        except TriangulationError as error:
            self._health.fault(WARN, f'no position: {error}')
            self._health.count('instants refused')
            self._health.show('last refusal', error)
            return
        self._points.publish(point_message(position, self._frame_id))
        self._poses.publish(pose_message(position, self._frame_id))
        self._health.left(position.stamp_ns)
        self._health.count('positions')
        self._health.ok('target placed')
        self._position = position
        odd = {name for name, _ in position.outliers}
        self._seen_by = ', '.join(name for name in names if name not in odd)
        for name, sigmas in position.outliers:
            self._health.count(f'rays of {name} that pass by')
            self._health.fault(
                WARN,
                f'the ray of {name} passes the others by, {sigmas:.1f} sigma: it is of another '
                f'light, a reflection say, or {name} is not where its pose says; it is not used',
            )

    def _at_one_place(self) -> str:
        """Return which cameras are at one place; empty if none are."""
        placed = self._places.last().items()
        return next((
            f'{one} and {other}' for (one, place), (other, another) in combinations(placed, 2)
            if float(np.linalg.norm(place.position - another.position)) < LEAST_BASELINE_M
        ), '')

    def _check_cameras(self) -> None:
        """Report cameras without a place of their own, silent ones, and rays in vain."""
        self._release()
        for name in self._places.unknown:
            begin = pose_of(name)
            self._health.fault(
                ERROR,
                f'{name} has no pose and is not used; set {begin}.x, {begin}.y, {begin}.z and its '
                'turn to where it is in frame_id, take the file that calibrate rig writes, or set '
                'use_tf if TF has it',
            )
        if both := self._at_one_place():
            self._health.fault(
                ERROR,
                f'{both} are at the same position, and the light has none; set x, y and z of '
                'their poses to where they are in frame_id, or use_tf if TF has them',
            )
        if not self._health.starting:
            self._check_silence()
        skipped, self._skipped = self._pairing.skipped - self._skipped, self._pairing.skipped
        if skipped:
            self._health.fault(
                WARN,
                f'{skipped} rays had none of another camera near enough, the last two were '
                f'{self._pairing.gap:.3f} s apart; raise max_interval, or name the camera with '
                'fewer rays first',
            )
        unseen, self._unseen = self._pairing.unseen - self._unseen, self._pairing.unseen
        if unseen:
            self._health.fault(
                WARN,
                f'{unseen} rays are of instants at which the other cameras do not see the light '
                'yet, or no more; they give no position',
            )
        for camera, late, told in zip(
            self._cameras, self._pairing.late, self._late, strict=True
        ):
            if late > told:
                self._health.fault(
                    WARN,
                    f'{late - told} rays on {camera.topic} came too late to be used: more than '
                    'max_interval after those of two others; raise it, or look for what holds '
                    'them up',
                )
        self._late = list(self._pairing.late)

    def _check_silence(self) -> None:
        """Report cameras of which nothing ever came, and those that leave a single one."""
        now = time.monotonic()
        heard = [each for each in self._cameras if now - each.came < SILENCE_S]
        silent = [each for each in self._cameras if each not in heard]
        if len(heard) == 1:
            self._health.fault(
                WARN,
                f'{_topics_of(silent)} {"is" if len(silent) == 1 else "are"} silent and '
                f'{heard[0].topic} is not: there is no position; does that camera see the light, '
                'and is the name right?',
            )
        elif heard:
            for camera in silent:
                if camera.came == -math.inf:
                    self._health.fault(
                        WARN,
                        f'nothing has ever come on {camera.topic}; is the name right, and does '
                        'the camera run and see the light?',
                    )
        self._health.show('silent cameras', ', '.join(each.name for each in silent) or 'none')

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
        self._health.show('chi-square', f'{position.chi2:.2f} of {position.degrees_of_freedom}')
        self._health.show('placed by', self._seen_by)


def _topics(names: Sequence[str], target: str) -> dict[str, str]:
    """Return the topic of each camera; raise ParameterError where one cannot be."""
    if len(names) < 2:
        raise ParameterError(
            f"parameter 'cameras' is [{', '.join(names)}]; a position takes two or more cameras: "
            'cameras:=[left, right]'
        )
    topics: dict[str, str] = {}
    for name in names:
        topic = f'{name.rstrip("/")}/{target}/ray'
        try:
            validate_topic_name(topic)
        except InvalidTopicNameException as error:
            raise ParameterError(f"parameter 'cameras': {error}") from None
        if not name.strip('/') or pose_of(name) in map(pose_of, topics):
            raise ParameterError(
                f"parameter 'cameras' is [{', '.join(names)}], with "
                f'{f"{name} twice" if name.strip("/") else "a camera without a name"}; each '
                'camera has its own namespace'
            )
        topics[name] = topic
    return topics


def _unknown(name: str, names: Iterable[str], cameras: Sequence[str]) -> ParameterError:
    """Return the error for a parameter that there is not, or no more."""
    role, _, rest = name.partition('.')
    if role in FORMER and rest:
        camera = dict(zip(FORMER, cameras))[role]
        now = 'cameras' if rest == 'namespace' else f'{pose_of(camera)}.{rest}'
        return ParameterError(
            f"no parameter '{name}'; it is '{now}' now: the cameras have names, and there may be "
            'more than two'
        )
    if role == 'poses':
        return ParameterError(
            f"no parameter '{name}'; cameras is [{', '.join(cameras)}], and each of these has a "
            f'pose, {pose_of(cameras[0])}.x and so on'
        )
    return unknown(name, names)


def _shared(triangle: Sequence[float], cameras: int) -> Array | None:
    """Return the covariance of the cameras' poses of its lower triangle, row by row."""
    if list(triangle) == [0.0]:
        return None
    size = 6 * cameras
    count = size * (size + 1) // 2
    if len(triangle) != count:
        raise ParameterError(
            f"parameter 'pose_covariance' has {len(triangle)} numbers; for {cameras} cameras it "
            f'must be {count}, or a single 0.0'
        )
    lower = np.zeros((size, size))
    lower[np.tril_indices(size)] = triangle
    covariance = lower + np.tril(lower, -1).T
    deviations = np.sqrt(np.abs(covariance.diagonal()))
    scale = np.where(deviations > 0.0, deviations, 1.0)
    values = np.linalg.eigvalsh(covariance / np.outer(scale, scale)) if (
        np.isfinite(covariance).all()
    ) else np.array([-math.inf])
    if values[0] < LEAST_EIGENVALUE:
        raise ParameterError(
            "parameter 'pose_covariance' is not a covariance: it must be finite and positive "
            'semidefinite; take it from the file that calibrate rig writes'
        )
    return covariance


def _part(shared: Array | None, which: Sequence[int]) -> Array | None:
    """Return the covariance of the poses of some cameras."""
    if shared is None:
        return None
    rows = [6 * number + each for number in which for each in range(6)]
    return shared[np.ix_(rows, rows)]


def _topics_of(cameras: Iterable[_Camera]) -> str:
    return ', '.join(each.topic for each in cameras)


def main() -> None:
    """Run the node."""
    sys.exit(run(lambda: [TriangulatorNode()]))
