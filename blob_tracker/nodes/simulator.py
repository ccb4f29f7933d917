"""A camera before simulated flashing lights: it publishes what a camera does, and the truth."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace
from functools import lru_cache
import sys
from typing import Any

from blob_tracker.camera import CameraModel, pinhole_matrix
from blob_tracker.capture.picture import draw
from blob_tracker.flash_text import codes_from_text, frequencies_from_text, numbered_lights
from blob_tracker.nodes.interface.flash import FLASH
from blob_tracker.nodes.interface.simulator import PARAMETERS, STILL
from blob_tracker.ros.diagnostics.connections import Connections
from blob_tracker.ros.diagnostics.health import Health, WARN
from blob_tracker.ros.endpoints.debug_image import DebugImage
from blob_tracker.ros.endpoints.delivery import Deliver
from blob_tracker.ros.endpoints.frame_topics import FrameTopics
from blob_tracker.ros.endpoints.names import check_light
from blob_tracker.ros.endpoints.qos import publisher, RESULT, subscription
from blob_tracker.ros.errors import MessageError, ParameterError
from blob_tracker.ros.messages.body import true_pose_message
from blob_tracker.ros.messages.camera_info import from_camera_model
from blob_tracker.ros.messages.imu import NO_DATA
from blob_tracker.ros.messages.joint_states import to_angles
from blob_tracker.ros.messages.stamp import from_ns
from blob_tracker.ros.messages.target import bearing_message, centroid_message
from blob_tracker.ros.parameters.declaration import declare, on_change
from blob_tracker.ros.parameters.values import about
from blob_tracker.ros.process import run
from blob_tracker.simulation import (
    blinking_lights, flashing_light, Light, PROFILES, Scene, Sensor, Truth, truth_of, waveforms_of,
)
from blob_tracker.simulation.flying_body import Flight, flying_body
from blob_tracker.simulation.gyro import Gyro
from blob_tracker.simulation.pan_tilt import Joints, KEPT_S, PanTilt
from blob_tracker.simulation.pan_tilt_camera import PanTiltCamera
from blob_tracker.simulation.platform_motion import MOTIONS, Ride
from blob_tracker.simulation.spot import LightSource
from blob_tracker.simulation.steered_camera import Felt, SteeredCamera
from blob_tracker.types import Frame, Location, SensorNoise
from geometry_msgs.msg import PointStamped, PoseStamped, Vector3Stamped
import numpy as np
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.timer import Timer
from sensor_msgs.msg import CameraInfo, Imu, JointState

RIDE_S = 300.0  # s, after which it begins again: the vehicle leaps, once in five minutes
BACK_S = 0.1  # s that the clock may go back as it is slewed; else it was set back
BEHIND = 1.0  # s by which the stamps may be off the clock: it was set, or the process stood still
EXPOSURE = 0.5  # of the frame interval, where flash.exposure is 0
IN_STEP = 'alternate'
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
        self._truths: dict[str, tuple[Publisher, Publisher]] = {}  # of all lights there ever were
        self._add_truth('')
        self._beats: list[Timer] = []
        self._pan_tilt_states: Publisher | None = None
        self._imus: Publisher | None = None
        self._true_poses = publisher(self, PoseStamped, 'simulator/truth/pose', RESULT)
        self._vehicle: SteeredCamera | None = None
        self._steered = False
        self._change(values)()
        on_change(self, PARAMETERS, self._change)

    def _change(self, values: dict[str, Any]) -> Callable[[], None]:
        """Build the scene and the camera of these parameters; return what starts them."""
        settings = dict(values)
        frame_id, focal_length = settings.pop('frame_id'), settings.pop('focal_length')
        platform, steered = settings.pop('platform'), settings.pop('pan_tilt')
        body_url = settings.pop('body_url')
        sensor = Sensor(
            SensorNoise(settings.pop('noise.gain'), settings.pop('noise.read_noise')),
            settings.pop('bits'),
            row_time=settings.pop('row_time'),
        )
        settings['profile'] = profile = PROFILES[settings['profile']]
        rides_on = steered or platform != STILL
        scene, lights, free = _scene(settings, sensor)
        if rides_on and values['flash.mode'] != IN_STEP:
            raise ParameterError(
                f"parameter 'flash.mode' is {values['flash.mode']!r}; it must be {IN_STEP!r} with "
                'platform or pan_tilt'
            )
        if rides_on and values['flash.lights'] > 1:
            raise ParameterError(
                f"parameter 'flash.lights' is {values['flash.lights']}; it must be 1 with "
                'platform or pan_tilt'
            )
        width, height = scene.width, scene.height
        model = CameraModel(width, height, pinhole_matrix(focal_length, width, height))
        flight: Flight | None = None
        if body_url:
            scene, lights, flight = _on_body(
                body_url, scene, lights, model, np.random.default_rng([values['seed'], 12]))
        try:
            pixels = scene.frame(0)
        except MemoryError:
            raise ParameterError(
                f'there is no room for frames of {width} x {height} px; take smaller ones'
            ) from None
        rides: tuple[PanTiltCamera, Felt] | None = None
        if rides_on:
            ride, felt = _ride(platform, values['seed'])
            rides = PanTiltCamera(
                model,
                ride,
                lambda times: np.tile(AHEAD, (len(times), 1)),
                sigma=values['sigma'],
                amplitude=values['amplitude'],
                profile=profile,
                background=values['background'],
                texture=values['texture'],
                sensor=sensor,
                region=(width, height),
                seed=values['seed'],
            ), felt
            taken = rides[0].exposure + rides[0].readout
            if taken > KEPT_S:
                raise ParameterError(
                    f"parameter 'row_time' is {sensor.row_time:g} s, with which a frame takes "
                    f'{taken:g} s; with platform or pan_tilt it must take no longer than '
                    f'{KEPT_S:g} s'
                )
            if self._imus is None:
                self._imus = publisher(self, Imu, 'imu', RESULT)
        if steered and self._pan_tilt_states is None:
            self._pan_tilt_states = publisher(self, JointState, 'joint_states', RESULT)
            subscription(self, JointState, 'joint_command', self._command, RESULT)
        for name in lights:
            self._add_truth(name)

        def use() -> None:
            self._frame_id = frame_id
            self._scene = scene
            self._lights = lights
            self._free = free
            self._flight = flight
            self._stamp_ns = self.get_clock().now().nanoseconds
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
            angles = to_angles(message, JOINTS)
            if not angles:
                raise MessageError(f'it is not of the joints {" and ".join(JOINTS)}')
            time = self._time(self.get_clock().now().nanoseconds)
            self._vehicle.advance(time)
            self._vehicle.pan_tilt.command(*(angles.get(name) for name in JOINTS))
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

    def _add_truth(self, light: str) -> None:
        """Have the topics of a light's truth."""
        if light not in self._truths:
            topic = f'simulator/truth/{light}' if light else 'simulator/truth'
            self._truths[light] = (
                publisher(self, PointStamped, f'{topic}/centroid', RESULT),
                publisher(self, Vector3Stamped, f'{topic}/bearing', RESULT),
            )

    def _regular(self, now_ns: int) -> int:
        """
        Return the stamp of a frame at equal intervals, and leave out those whose time is over.

        A frame shows what its number says: the time at which this process woke would jitter
        beside it. Of a light in step two are left out at once, one of either kind.
        """
        interval_ns = int(1.0 / self._scene.rate * 1e9)  # as the timer has it
        late_ns = now_ns - self._stamp_ns
        if abs(late_ns - interval_ns) > 1e9 * BEHIND:
            self._stamp_ns = now_ns
            return now_ns
        over = max(late_ns // interval_ns - 1, 0)
        if not self._free:
            over -= over % 2
        if over:
            self._index += over
            self._pixels = self._scene.frame(self._index)
        self._stamp_ns += (over + 1) * interval_ns
        return self._stamp_ns

    def _picture(self) -> tuple[Frame, list[Truth]]:
        """Return the next frame: the one that is ready, or that whose exposure ends now."""
        now_ns = self.get_clock().now().nanoseconds
        sensor = self._scene.sensor
        if self._vehicle is None:
            end_ns = self._regular(now_ns)
            frame = Frame(
                self._pixels, end_ns - self._scene.before_middle_ns, sensor.saturation,
                exposure_ns=round(1e9 * self._scene.exposure / self._scene.rate),
                line_time_ns=1e9 * sensor.row_time,
            )
            shot = self._scene.shot(self._index)
            return frame, [truth_of(light, shot) for light in self._lights.values()]
        camera = self._vehicle.camera
        taken = camera.exposure + camera.readout
        end = max(self._time(now_ns), self._vehicle.pan_tilt.time, taken)
        frame, truth = self._vehicle.picture(self._index, end)
        self._publish_states()  # on their way before the frame: who tracks it waits for them
        first_ns = self._begin_ns + frame.stamp_ns - 10**9  # its time counts from 1 s on
        return replace(frame, stamp_ns=first_ns), [truth]

    def _publish(self) -> None:
        """Publish a frame, then draw the next, if it is known: drawing costs no latency."""
        frame, truths = self._picture()
        stamp_ns = frame.stamp_ns
        self._health.arrived(stamp_ns)
        self._frames.publish(frame, self._info, self._frame_id)
        self._health.left(stamp_ns)
        if self._flight is not None:
            shot = self._scene.shot(self._index)
            self._true_poses.publish(true_pose_message(
                *self._flight.pose(shot.time),
                stamp_ns + round(shot.middle_row * frame.line_time_ns), self._frame_id,
            ))
        for name, truth in zip(self._lights, truths):
            # The row that it lies in is exposed so much later than the first.
            self._tell(name, truth, stamp_ns + round(np.nan_to_num(truth.y) * frame.line_time_ns))
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

    def _tell(self, light: str, truth: Truth, stamp_ns: int) -> None:
        """Publish where a light is in a frame, if it shows there."""
        if not (truth.amplitude > 0.0 and np.isfinite(truth.x + truth.y)):
            return
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
            stamp_ns=stamp_ns + round(1e9 * truth.tau),
        )
        bearing = self._camera_model.bearing(location)
        centroids, bearings = self._truths[light]
        centroids.publish(centroid_message(location, self._frame_id))
        bearings.publish(bearing_message(bearing, self._frame_id))


def _scene(
    settings: dict[str, Any], sensor: Sensor
) -> tuple[Scene, dict[str, LightSource], bool]:
    """
    Return the scene of these parameters.

    Returns
    -------
    Scene
        With the lights in it.
    dict of str to LightSource
        Those whose truth is told, by name.
    bool
        Whether they have a time of their own.

    """
    flash = {each.name: settings.pop(each.name) for each in FLASH}
    clock_error = settings.pop('clock_error')
    mode, rate = flash['flash.mode'], settings['rate']
    exposure = flash['flash.exposure'] * rate or EXPOSURE
    if exposure > 1.0:
        raise ParameterError(
            f"parameter 'flash.exposure' is {flash['flash.exposure']:g} s; it must be no longer "
            f'than a frame, {1.0 / rate:g} s'
        )
    try:
        if mode == IN_STEP and flash['flash.lights'] == 1:
            scene = replace(flashing_light(**settings, sensor=sensor), exposure=exposure)
            assert scene.target is not None
            return scene, {'': scene.target}, False
        with about('flash'):
            codes = codes_from_text(flash['flash.codes'])
            frequencies = frequencies_from_text(flash['flash.frequencies'])
            for name in (*codes, *frequencies):
                check_light(name)
            if mode == 'coded':
                # Loads Numba: a light in step does without.
                from blob_tracker.segmentation.patterns import check_patterns

                check_patterns(codes, frequencies, flash['flash.duty'])
            waveforms = waveforms_of(
                mode,
                rate=rate,
                frequency=flash['flash.frequency'],
                duty=flash['flash.duty'],
                frequencies=frequencies,
                codes=codes,
                frames_per_bit=flash['flash.frames_per_bit'],
                bits_per_second=flash['flash.bits_per_second'],
                clock_error=clock_error,
                lights=numbered_lights(flash['flash.lights']),
            )
        scene, lights = blinking_lights(
            waveforms, **settings, exposure=exposure, sensor=sensor
        )
    except ParameterError:
        raise
    except ValueError as error:
        raise ParameterError(f'{error}; lower row_time, height or rate') from None
    in_step = mode == IN_STEP or (
        mode == 'coded' and not frequencies and not flash['flash.bits_per_second'])
    return scene, {**lights}, not in_step


def _on_body(
    url: str, scene: Scene, lights: dict[str, LightSource], model: CameraModel,
    random: np.random.Generator,
) -> tuple[Scene, dict[str, LightSource], Flight]:
    """
    Return the scene with its lights on a body, these, and how it flies.

    The body is one that was built: each light is off its place in the file by its sigma.
    """
    # Loads Numba: lights by themselves do without.
    from blob_tracker.ros.parameters.body import body_of

    body = body_of(url)
    alone = {name: light for name, light in lights.items() if isinstance(light, Light)}
    # Without names they are those of the file in its order.
    names = tuple(alone) if tuple(alone) == numbered_lights(len(body.names)) else body.names
    if not body.names or set(alone) != set(names):
        raise ParameterError(
            f"parameter 'body_url': the body has the lights {', '.join(body.names)}, and "
            f'flash.codes, in flash.mode coded, {", ".join(filter(None, alone)) or "none"}; they '
            'must be the same, or flash.lights as many in the modes steady and alternate'
        )
    built = body.places + body.sigmas[:, None] * random.standard_normal(body.places.shape)
    places = dict(zip(names, built, strict=True))
    scene, of_body, flight = flying_body(scene, alone, places, model.matrix)
    return scene, {**of_body}, flight


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
