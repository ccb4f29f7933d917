"""target/<light>/ray of a body's lights -> target/<body>/pose and target/<body>/twist."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
import sys
from typing import Any

from blob_tracker.camera import compile_lens
from blob_tracker.constellation import (
    Assignment, Body, compile_ahead, ConstellationError, Following, Pose, Sighting,
)
from blob_tracker.nodes.interface.constellation import PARAMETERS
from blob_tracker.ros.diagnostics.clock_jumps import on_clock_jump
from blob_tracker.ros.diagnostics.connections import Connections
from blob_tracker.ros.diagnostics.health import ERROR, Health, WARN
from blob_tracker.ros.endpoints.names import check_light, lights_from_text, target_topic
from blob_tracker.ros.endpoints.qos import publisher, RESULT, subscription
from blob_tracker.ros.endpoints.transforms import TransformBroadcaster
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.body import (
    body_pose_message, body_transform_message, body_twist_message,
)
from blob_tracker.ros.messages.ray import of_another_camera, to_bearing
from blob_tracker.ros.parameters.body import body_of
from blob_tracker.ros.parameters.declaration import declare, on_change
from blob_tracker.ros.parameters.values import about
from blob_tracker.ros.process import run
from blob_tracker.types import Bearing
from geometry_msgs.msg import PoseWithCovarianceStamped, TwistWithCovarianceStamped
import numpy as np
from rclpy.node import Node

FOLLOWED_S = 0.5  # after which a light without a name may be another one


class ConstellationNode(Node):
    """See the module's first line; the work is that of the room `constellation`."""

    def __init__(self) -> None:
        super().__init__('constellation')
        values = declare(self, PARAMETERS)
        self._body: Body = body_of(values['body_url'])
        with about('body'):
            check_light(values['body'])
        unnamed = tuple(filter(None, lights_from_text(values['unnamed'], 'unnamed')))
        lights = unnamed or self._body.names
        self._assignment = Assignment(self._body, FOLLOWED_S) if unnamed else None
        self._health = Health(
            self,
            f'no ray arrives of {", ".join(lights)}; does a locator run, and do its lights and '
            'flash.codes of the segmenter have the names of the body file, or those of unnamed?',
            describe=self._describe,
        )
        self._connections = Connections(self, self._health)
        self._pose: Pose | None = None
        self._body_frame = values['body']
        self._broadcaster: TransformBroadcaster | None = None
        self._following = Following(self._body)
        self._frame_id: str | None = None  # that of the first ray
        self._sighting = Sighting(lights, values['max_interval'])
        self._change(values)()
        on_change(self, PARAMETERS, self._change)
        target = target_topic(values['body'])
        self._poses = publisher(self, PoseWithCovarianceStamped, f'{target}/pose', RESULT)
        self._twists = publisher(self, TwistWithCovarianceStamped, f'{target}/twist', RESULT)
        for light in lights:
            subscription(
                self, PoseWithCovarianceStamped, f'{target_topic(light)}/ray',
                partial(self._take, light), RESULT,
            )
        self._clock_jumps = on_clock_jump(self, self._health, self._forget)

    def _change(self, values: dict[str, Any]) -> Callable[[], None]:
        """Return what puts these parameters into effect."""
        if values['publish_tf'] and self._broadcaster is None:
            self._broadcaster = TransformBroadcaster(self, 'publish_tf')

        def use() -> None:
            self._sighting.max_interval = values['max_interval']
            self._publishes_tf = values['publish_tf']
            self._max_distance = values['max_distance']
            self._options = {
                'speed_sigma': values['speed_sigma'],
                'rate_sigma': values['rate_sigma'],
                'gate_sigma': values['gate'],
            }

        return use

    def _take(self, light: str, message: PoseWithCovarianceStamped) -> None:
        """Take a ray of a light; publish the pose of the sighting that it ends."""
        frame_id = message.header.frame_id
        if self._frame_id is None:
            self._frame_id = frame_id
        if frame_id != self._frame_id:
            complaint = of_another_camera(f'the ray of {light}', frame_id, self._frame_id)
            self._health.fault(ERROR, complaint)
            return
        try:
            bearing = to_bearing(message)
            self._health.arrived(bearing.stamp_ns)
            self._health.count('rays')
            bearings = self._sighting.take(light, bearing)
        except MessageError as error:
            self._health.fault(ERROR, f'{light}: {error}')
            return
        except ConstellationError as error:
            self._health.fault(WARN, f'{light}: {error}')
            return
        if bearings:
            self._publish(bearings)

    def _forget(self, after_ns: int) -> None:
        """Give up what is later than a jump of the clock, and begin to follow anew."""
        self._sighting.forget(after_ns)
        self._following.forget()

    def _publish(self, bearings: list[tuple[str, Bearing]]) -> None:
        """Publish the pose of these bearings, or say why there is none."""
        try:
            if self._assignment is not None:
                bearings = self._assignment.name(
                    [each for _, each in bearings], **self._options)
            names = [name for name, _ in bearings]
            self._health.show('lights seen together', ', '.join(names))
            found = self._following.take(bearings, **self._options)
        except ConstellationError as error:
            self._refuse(str(error))
            return
        if len(found) > 1:
            self._refuse(
                f'{len(found)} poses of the body explain the bearings of {", ".join(names)}, and '
                'none is refuted by those before; let more lights be seen, and one of them out of '
                'the plane of the others'
            )
            return
        pose = self._pose = found[0]
        self._poses.publish(body_pose_message(pose, str(self._frame_id)))
        self._twists.publish(body_twist_message(pose, str(self._frame_id)))
        if self._broadcaster is not None and self._publishes_tf:
            self._broadcaster.send(
                [body_transform_message(pose, str(self._frame_id), self._body_frame)]
            )
        self._health.left(pose.stamp_ns)
        self._health.count('poses')
        self._health.ok('body placed')
        distance = float(np.linalg.norm(pose.position))
        if distance > self._max_distance:
            self._health.fault(
                WARN,
                f'by its file the body is {distance:.0f} m away, further than max_distance: are '
                'its positions in mm? They must be in m',
            )
        if pose.outliers:
            self._health.fault(
                WARN,
                f'the bearing of {", ".join(pose.outliers)} is of another light, a reflection '
                'say, or its position in the body file is wrong; it is not used',
            )

    def _refuse(self, reason: str) -> None:
        """Say why there is no pose."""
        self._health.fault(WARN, f'no pose: {reason}')
        self._health.count('sightings refused')
        self._health.show('last refusal', reason)

    def _describe(self) -> None:
        """Show in the diagnostics what was found last."""
        pose = self._pose
        if pose is None:
            return
        deviations = np.sqrt(pose.covariance.diagonal())
        for axis, place, sigma in zip('xyz', pose.position, deviations[:3], strict=True):
            self._health.show(f'{axis} (m)', f'{place:.4f} +- {sigma:.4f}')
        self._health.show('greatest sigma of a turn (rad)', f'{deviations[3:].max():.4f}')
        self._health.show('chi-square', f'{pose.chi2:.2f} of {pose.degrees_of_freedom}')
        self._health.show('outliers', ', '.join(pose.outliers))


def compile_fit() -> None:
    """Compile the fit, before the first ray could wait for it."""
    compile_ahead()
    compile_lens()


def main() -> None:
    """Run the node."""
    sys.exit(run(lambda: [ConstellationNode()], compile_fit))
