"""A camera before a simulated flashing light: it publishes what a camera does, and the truth."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace
from functools import lru_cache
import sys
from typing import Any

from blob_tracker.camera import CameraModel, pinhole_matrix
from blob_tracker.capture.picture import draw
from blob_tracker.nodes.interface.simulator import PARAMETERS, STILL
from blob_tracker.ros.diagnostics.connections import Connections
from blob_tracker.ros.diagnostics.health import Health, WARN
from blob_tracker.ros.endpoints.debug_image import DebugImage
from blob_tracker.ros.endpoints.delivery import Deliver
from blob_tracker.ros.endpoints.frame_topics import FrameTopics
from blob_tracker.ros.endpoints.qos import publisher, RESULT, subscription
from blob_tracker.ros.errors import MessageError, ParameterError
from blob_tracker.ros.messages.camera_info import from_camera_model
from blob_tracker.ros.messages.imu import NO_DATA
from blob_tracker.ros.messages.joint_states import to_angle
from blob_tracker.ros.messages.stamp import from_ns
from blob_tracker.ros.messages.target import bearing_message, centroid_message
from blob_tracker.ros.parameters.declaration import declare, on_change
from blob_tracker.ros.process import run
from blob_tracker.simulation import flashing_light, PROFILES, Sensor, Truth
from blob_tracker.simulation.gyro import Gyro
from blob_tracker.simulation.pan_tilt import Joints, PanTilt
from blob_tracker.simulation.pan_tilt_camera import PanTiltCamera
from blob_tracker.simulation.platform_motion import MOTIONS, Ride
from blob_tracker.simulation.steered_camera import Felt, SteeredCamera
from blob_tracker.types import Frame, Location, SensorNoise
from geometry_msgs.msg import PointStamped, Vector3Stamped
import numpy as np
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.timer import Timer
from sensor_msgs.msg import CameraInfo, Imu, JointState

RIDE_S = 300.0  # s, after which it begins again: the vehicle leaps, once in five minutes
BACK_S = 0.1  # s that the clock may go back as it is slewed; else it was set back
JOINTS = ('pan', 'tilt')
GYRO = Gyro()
AHEAD = (0.0, 0.0, 1.0)  # the direction of the light, in the level frame


class SimulatorNode(Node):
    """
    See the module's first line; the work is that of `blob_tracker.simulation`.

    Parameters
    ----------
    deliver : callable, optional
        Takes each frame in memory, see `FrameTopics`.
    elsewhere : collection of str
        Parameters of other nodes in the same process.

    """

    def __init__(
        self,
        *,
        deliver: Deliver[tuple[Frame, CameraInfo]] | None = None,
        elsewhere: Collection[str] = (),
    ) -> None:
        super().__init__('simulator')
        values = declare(self, PARAMETERS, elsewhere)
        self._health = Health(
            self,
            'no frame was published',
            'drawing takes longer than a frame; lower rate, width and height, or free the '
            'processor',
        )
        self._connections = Connections(self, self._health)
        self._debug_image = DebugImage(self)
        self._frames = FrameTopics(self, self._health, deliver)
        self._centroids, self._bearings = (
            publisher(self, kind, name, RESULT)
            for kind, name in (
                (PointStamped, 'simulator/truth/centroid'),
                (Vector3Stamped, 'simulator/truth/bearing'),
            )
        )
        self._beats: list[Timer] = []
        self._pan_tilt_states: Publisher | None = None
        self._imus: Publisher | None = None
        self._vehicle: SteeredCamera | None = None
        self._steered = False
        self._change(values)()
        on_change(self, PARAMETERS, self._change)

    def _change(self, values: dict[str, Any]) -> Callable[[], None]:
        """Build the scene and the camera of these parameters; return what starts them."""
        settings = dict(values)
        frame_id, focal_length = settings.pop('frame_id'), settings.pop('focal_length')
        platform, steered = settings.pop('platform'), settings.pop('pan_tilt')
        sensor = Sensor(
            SensorNoise(settings.pop('noise.gain'), settings.pop('noise.read_noise')),
            settings.pop('bits'),
            row_time=settings.pop('row_time'),
        )
        profile = PROFILES[settings.pop('profile')]
        try:
            scene = flashing_light(**settings, profile=profile, sensor=sensor)
        except ValueError as error:
            raise ParameterError(f'{error}; lower row_time, height or rate') from None
        width, height = scene.width, scene.height
        model = CameraModel(width, height, pinhole_matrix(focal_length, width, height))
        try:
            pixels = scene.frame(0)
        except MemoryError:
            raise ParameterError(
                f'there is no room for frames of {width} x {height} px; take smaller ones'
            ) from None
        rides: tuple[PanTiltCamera, Felt] | None = None
        if steered or platform != STILL:
            ride, felt = _ride(platform, settings['seed'])
            rides = PanTiltCamera(
                model,
                ride,
                lambda times: np.tile(AHEAD, (len(times), 1)),
                sigma=settings['sigma'],
                amplitude=settings['amplitude'],
                profile=profile,
                background=settings['background'],
                texture=settings['texture'],
                sensor=sensor,
                region=(width, height),
                seed=settings['seed'],
            ), felt
            if self._imus is None:
                self._imus = publisher(self, Imu, 'imu', RESULT)
        if steered and self._pan_tilt_states is None:
            self._pan_tilt_states = publisher(self, JointState, 'joint_states', RESULT)
            subscription(self, JointState, 'joint_command', self._command, RESULT)

        def use() -> None:
            self._frame_id = frame_id
            self._scene = scene
            self._camera_model = model
            self._info = from_camera_model(model, width, height)
            self._index = 0
            self._pixels = pixels
            before = self._vehicle if steered == self._steered else None
            self._vehicle, self._steered = None, steered
            if rides is not None:
                pan_tilt = PanTilt(Joints()) if before is None else before.pan_tilt
                self._vehicle = SteeredCamera(rides[0], pan_tilt, GYRO, rides[1])
                if before is None:
                    self._begin_ns = self.get_clock().now().nanoseconds
            for timer in self._beats:
                self.destroy_timer(timer)
            self._beats = [self.create_timer(1.0 / self._scene.rate, self._publish)]
            if self._vehicle is not None:
                self._beats.append(self.create_timer(1.0 / GYRO.rate, self._publish_states))

        return use

    def _time(self, now_ns: int) -> float:
        """Return the time since the ride began, s; it begins again where it is over."""
        assert self._vehicle is not None
        time = 1e-9 * (now_ns - self._begin_ns)
        if not self._vehicle.pan_tilt.time <= time + BACK_S or time > RIDE_S:
            self._begin_ns = now_ns
            self._vehicle = self._vehicle.again()
            return 0.0
        return time

    def _command(self, message: JointState) -> None:
        """Have the pan/tilt go where it is told to."""
        if self._vehicle is None or not self._steered:
            return
        try:
            pan, tilt = (to_angle(message, name, False) for name in JOINTS)
            if pan is None or tilt is None:
                raise MessageError(f'it is not of the joints {" and ".join(JOINTS)}')
            time = self._time(self.get_clock().now().nanoseconds)
            self._vehicle.advance(time)
            self._vehicle.pan_tilt.command(pan, tilt)
        except ValueError as error:
            self._health.fault(WARN, f'joint_command: {error}')

    def _publish_states(self) -> None:
        """Publish how the vehicle turned, and where the pan/tilt stood."""
        if self._vehicle is None or self._imus is None:
            return  # the parameters changed while this call was under way
        time = self._time(self.get_clock().now().nanoseconds)
        self._vehicle.advance(time)
        imu, states = Imu(), JointState(name=list(JOINTS))
        imu.header.frame_id = 'imu_link'
        imu.orientation_covariance[0] = imu.linear_acceleration_covariance[0] = NO_DATA
        imu.angular_velocity_covariance[[0, 4, 8]] = GYRO.variance
        for state in self._vehicle.states():
            imu.header.stamp = from_ns(self._begin_ns + round(1e9 * state.felt_time))
            x, y, z = state.rate
            # x forward, y left, z up.
            imu.angular_velocity.x, imu.angular_velocity.y, imu.angular_velocity.z = z, -x, -y
            self._imus.publish(imu)
            if self._steered and self._pan_tilt_states is not None:
                states.header.stamp = from_ns(self._begin_ns + round(1e9 * state.time))
                states.position = state.angles
                self._pan_tilt_states.publish(states)

    def _picture(self) -> tuple[Frame, Truth]:
        """Return the next frame: the one that is ready, or that whose exposure ends now."""
        now_ns = self.get_clock().now().nanoseconds
        sensor = self._scene.sensor
        if self._vehicle is None:
            frame = Frame(
                self._pixels, now_ns - self._scene.before_middle_ns, sensor.saturation,
                exposure_ns=round(1e9 * self._scene.exposure / self._scene.rate),
                line_time_ns=1e9 * sensor.row_time,
            )
            return frame, self._scene.truth(self._index)
        camera = self._vehicle.camera
        taken = camera.exposure + camera.readout
        end = max(self._time(now_ns), self._vehicle.pan_tilt.time, taken)
        frame, truth = self._vehicle.picture(self._index, end)
        self._publish_states()  # on their way before the frame: who tracks it waits for them
        first_ns = self._begin_ns + frame.stamp_ns - 10**9  # its time counts from 1 s on
        return replace(frame, stamp_ns=first_ns), truth

    def _publish(self) -> None:
        """Publish a frame, then draw the next, if it is known: drawing costs no latency."""
        frame, truth = self._picture()
        stamp_ns = frame.stamp_ns
        self._health.arrived(stamp_ns)
        self._frames.publish(frame, self._info, self._frame_id)
        self._health.left(stamp_ns)
        if truth.lit and np.isfinite(truth.x + truth.y):
            location = Location(
                x=truth.x,
                y=truth.y,
                covariance=np.zeros((2, 2)),
                amplitude=truth.amplitude,
                background=self._scene.background,
                sigma=truth.sigma,
                snr=np.inf,
                chi2=0.0,
                saturated=0,
                stamp_ns=stamp_ns + round(truth.y * frame.line_time_ns),
            )
            bearing = self._camera_model.bearing(location)
            self._centroids.publish(centroid_message(location, self._frame_id))
            self._bearings.publish(bearing_message(bearing, self._frame_id))
        self._health.count('frames')
        self._health.ok('publishing')
        self._debug_image.offer(
            lambda: draw(frame, [f'{self._health.rate:.2f} Hz of {self._scene.rate:g}']),
            stamp_ns,
            self._frame_id,
        )
        self._index += 1
        if self._vehicle is None:
            self._pixels = self._scene.frame(self._index)


@lru_cache(maxsize=2)
def _ride(platform: str, seed: int) -> tuple[Ride, Felt]:
    """Return how a vehicle turns, and what its gyro says of it: a second's work of a ride."""
    ride = (
        Ride(RIDE_S + 1.0, np.zeros((2, 3)), np.zeros((2, 3))) if platform == STILL
        else MOTIONS[platform].ride(RIDE_S + 1.0, seed)
    )
    return ride, GYRO.samples(ride, RIDE_S, np.random.default_rng([seed, 11]))


def main() -> None:
    """Run the node."""
    sys.exit(run(lambda: [SimulatorNode()]))
