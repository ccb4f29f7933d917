"""target/window -> target/bearing, target/centroid and target/ray."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace
from functools import partial
from pathlib import Path
import sys
from threading import Lock, Thread
import time
from typing import Any

from blob_tracker.calibration.pulse_file import PulseFile
from blob_tracker.camera import CalibrationError, CameraModel, compile_lens, LensError
from blob_tracker.camera.light_range import RangeError, Ranging
from blob_tracker.camera.response import OTHER_DEPTH, Response
from blob_tracker.location import compile_ahead, Learned, Locator, method_options
from blob_tracker.location.noise import noise_in_words, variance_ratio
from blob_tracker.location.noise_check import NoiseCheck
from blob_tracker.location.picture import draw
from blob_tracker.location.scatter import RecentPlaces
from blob_tracker.nodes.interface.locator import DEFAULT_METHOD, PARAMETERS
from blob_tracker.pipeline import window_to_bearing, window_to_range
from blob_tracker.ros.diagnostics.clock_jumps import on_clock_jump
from blob_tracker.ros.diagnostics.connections import Connections
from blob_tracker.ros.diagnostics.health import ERROR, Health, WARN
from blob_tracker.ros.endpoints.bearing_topics import BearingTopics
from blob_tracker.ros.endpoints.debug_image import DebugImage
from blob_tracker.ros.endpoints.delivery import Deliver, Delivery
from blob_tracker.ros.endpoints.names import lights_from_text, target_topic
from blob_tracker.ros.endpoints.pairing import FramePairs
from blob_tracker.ros.endpoints.qos import publisher, QuietPublisher, RESULT, STATE, subscription
from blob_tracker.ros.errors import MessageError, ParameterError
from blob_tracker.ros.messages.camera_info import KnownCamera
from blob_tracker.ros.messages.clipping import clipping_window
from blob_tracker.ros.messages.image import to_window
from blob_tracker.ros.messages.light_range import range_message
from blob_tracker.ros.messages.target import to_noise
from blob_tracker.ros.parameters.declaration import declare, on_change
from blob_tracker.ros.parameters.rooms import line_jitter_of, pulse_of, response_of
from blob_tracker.ros.parameters.url import to_path
from blob_tracker.ros.process import run
from blob_tracker.types import Bearing, Location, LocationError, SensorNoise, Window
from geometry_msgs.msg import Vector3Stamped
import numpy as np
from rclpy.node import Node
from rclpy.subscription import Subscription
from sensor_msgs.msg import CameraInfo, Image, Range

PLACES = 240  # of which the scatter is told to 5 %: the last 8 s at 30 Hz
# Ratio of the scatter of the places to their sigmas, or of the pixels' variance to their noise's:
# half more is more than calibrations differ by.
SUSPICIOUS = 1.5
RANGING = (
    'psf_sigma', 'diameter', 'reference_distance', 'reference_flux', 'calibration_sigma',
)
DIFFERENT = 1.5  # ratio of two variances; what is measured has sigmas far below that


class LocatorNode(Node):
    """
    See the module's first line; the work is that of the rooms `location` and `camera`.

    Parameters
    ----------
    listen : bool
        Whether windows come from target/window/...; else whoever has them calls `locate`.
    deliver : callable, optional
        Takes each bearing in memory.
    elsewhere : collection of str
        Parameters of other nodes in the same process.

    """

    def __init__(
        self,
        *,
        listen: bool = True,
        deliver: Deliver[Bearing] | None = None,
        elsewhere: Collection[str] = (),
    ) -> None:
        super().__init__('locator')
        values = declare(self, PARAMETERS, elsewhere)
        self._listen, self._deliver = listen, deliver
        self._lock = Lock()  # windows may come from a thread of the camera's
        self._health = Health(
            self,
            'no window arrives: the segmenter sees no target (its diagnostics say why), or is not '
            'running',
            describe=self._describe,
        )
        self._placed = self._health.tally('bearings')
        self._connections = Connections(self, self._health)
        self._lights: Collection[str] = ()
        self._places: dict[str, RecentPlaces] = {}
        self._noise_checks: dict[str, NoiseCheck] = {}
        self._by_windows = False  # whether the noise is that of the last window's check
        self._bearing: Bearing | None = None
        self._debug_image = DebugImage(self)
        self._camera = KnownCamera()
        self._targets: dict[str, BearingTopics] = {}
        self._windows: dict[str, FramePairs] = {}
        self._ranges: dict[str, QuietPublisher] = {}
        self._keep_at: Path | None = None  # of the pulse that is learned first
        self._not_kept = ''
        self._response: Response | None = None
        self._not_linear = ''
        self._measurements: Subscription | None = None
        self._measurement: SensorNoise | None = None
        self._change(values)()
        on_change(self, PARAMETERS, self._change)
        self._clock_jumps = on_clock_jump(self, self._health, self._forget)

    def _change(self, values: dict[str, Any]) -> Callable[[], None]:
        """Build what these parameters ask for; return what puts it into effect."""
        method = values['method']
        try:
            options = method_options(method, elliptical=values['elliptical'])
            locator = Locator(method, learn=values['pulse.learn'], **options)
        except ValueError as error:
            raise ParameterError(str(error)) from None
        compile_ahead([method])
        noise = SensorNoise(
            values['noise.gain'], values['noise.read_noise'], values['noise.black_level']
        )
        line_jitter = line_jitter_of(values['line_jitter_url'])
        response = response_of(values['response_url'])
        pulse, no_pulse = pulse_of(values['pulse_url'], method)
        keep_at = _new_file(values['pulse_url']) if values['pulse.learn'] else None
        if keep_at is not None:
            no_pulse = ''  # it is still to be learned
        try:
            ranging = Ranging(*(values[f'range.{name}'] for name in RANGING))
        except ValueError as error:
            raise ParameterError(str(error)) from None
        lights = lights_from_text(values['lights'])
        if self._listen:
            self._make_topics(lights)
        if ranging.tells_range:
            self._make_range_topics()

        def use() -> None:
            with self._lock:
                self._locator, self._keep_at = locator, keep_at
                self._saturation, self._looks = values['saturation'], values['looks']
                self._line_time_ns = 1e9 * values['line_time']
                self._configured = self._noise = noise
                self._noise_checks.clear()
                self._line_jitter, self._response = line_jitter, response
                self._not_linear = ''
                self._pulse, self._no_pulse = pulse, no_pulse
                self._ranging = ranging
                self._places.clear()  # the next ones are placed in another way
                if self._listen:
                    self._follow(lights)
                self._set_online(values['noise.online'])

        return use

    def set_lights(self, lights: Collection[str]) -> None:
        """Be told by the segmenter in this process which lights it will hand over."""
        self._make_topics(lights)
        if self._ranging.tells_range:
            self._make_range_topics()
        with self._lock:
            self._follow(lights)

    def _make_topics(self, lights: Collection[str]) -> None:
        """Have the topics of these lights; those of others stay, see `process.run`."""
        for name in lights:
            if name not in self._targets:
                self._targets[name] = BearingTopics(self, target_topic(name))
            if self._listen and name not in self._windows:
                self._windows[name] = FramePairs(
                    self, f'{target_topic(name)}/window', self._health, partial(self._take, name),
                    exact=True,
                )

    def _make_range_topics(self) -> None:
        """Have the topics of the ranges of all lights that there ever were."""
        for name in self._targets:
            if name not in self._ranges:
                self._ranges[name] = publisher(self, Range, f'{target_topic(name)}/range', RESULT)

    def _follow(self, lights: Collection[str]) -> None:
        """Place these lights and speak of no other."""
        self._lights = lights
        self._places = {name: self._places[name] for name in lights if name in self._places}

    def _set_online(self, online: bool) -> None:
        """Use the noise that the segmenter measures, or no longer."""
        self._online = online
        if not online:
            self._health.show('noise', f'as configured: {noise_in_words(self._configured)}')
        elif self._measurement is not None:
            self._use(self._measurement)
        else:
            self._health.show('noise', 'as configured: none has been measured yet')
        if online and self._measurements is None:
            self._measurements = subscription(
                self, Vector3Stamped, 'target/noise', self._measured, STATE
            )

    def _measured(self, message: Vector3Stamped) -> None:
        """Take the noise that the segmenter measured."""
        try:
            noise = to_noise(message)
        except MessageError as error:
            self._health.fault(ERROR, f'target/noise: {error}')
            return
        with self._lock:
            self._measurement = noise
            if self._online:
                self._use(noise)

    def _use(self, noise: SensorNoise) -> None:
        """Reckon with a noise that was measured."""
        self._noise = noise
        self._health.show('noise', f'as measured: {noise_in_words(noise)}')

    def _take(self, light: str, image: Image, info: CameraInfo) -> None:
        """Take a window from the topics."""
        try:
            window = to_window(image, info)
        except MessageError as error:
            self._health.fault(ERROR, f'{target_topic(light)}/window: {error}')
            return
        self.locate(Delivery((window, info), image.header.frame_id, light))

    def _forget(self, after_ns: int) -> None:
        """Forget the windows that wait for their camera_info and have a later stamp, ns."""
        for windows in self._windows.values():
            windows.forget(after_ns)
        with self._lock:
            self._locator.forget()

    def locate(self, delivery: Delivery[tuple[Window, CameraInfo]]) -> None:
        """Place the blob of a window and publish its direction, or nothing at all."""
        came_ns = time.monotonic_ns()
        window, info = delivery.item
        with self._lock:
            if delivery.light in self._lights:
                self._locate(delivery.light, window, info, delivery.frame_id)
        self._health.arrived(window.stamp_ns, came_ns)

    def _locate(self, light: str, window: Window, info: CameraInfo, frame_id: str) -> None:
        try:
            camera_model = self._camera.model(info)
            self._fit_pulse(camera_model)
            window = clipping_window(window, self._clipped_at(window, info), self._looks)
            if self._line_time_ns:
                window = replace(window, line_time_ns=self._line_time_ns)
            if light not in self._noise_checks:
                self._noise_checks[light] = NoiseCheck(self._configured)
            check = self._noise_checks[light]
            noise = check.noise if self._noise is self._configured else self._noise
            location, bearing = window_to_bearing(
                window,
                camera_model,
                locator=self._locator,
                noise=noise,
                line_jitter=self._line_jitter,
                light=light,
                check=check,
            )
        except MessageError as error:
            self._health.fault(ERROR, f'{target_topic(light)}/window: {error}')
            return
        except CalibrationError as error:
            self._health.fault(ERROR, f'line_jitter_url: {error}')
            return
        except (LocationError, LensError) as error:
            self._health.fault(WARN, f'target not located: {error}')
            self._health.count('windows refused')
            self._health.show('last refusal', error)
            why = str(error)
            self._debug_image.offer(
                lambda: draw(window, noise, reason=why, name=light),
                window.stamp_ns,
                frame_id,
            )
            return
        self._targets[light].publish(bearing, location, frame_id)
        if self._deliver is not None:
            self._deliver(Delivery(bearing, frame_id, light))
        self._health.left(window.stamp_ns)
        self._placed.count += 1
        self._health.ok('target located')
        if location.warning:
            self._health.fault(WARN, f'{target_topic(light)}: {location.warning}')
        self._bearing = bearing
        if light not in self._places:
            self._places[light] = RecentPlaces(PLACES)
        self._places[light].add(location)
        if self._not_linear:
            self._health.fault(WARN, f'response_url: {self._not_linear}')
        if self._no_pulse:
            self._health.fault(WARN, f'pulse_url: {self._no_pulse}; the Gaussian is fitted')
        elif self._not_kept:
            self._health.fault(WARN, f'pulse_url: {self._not_kept}; the pulse is used')
        if self._ranging.psf_sigma > 0.0:
            self._range(light, window, location, bearing, noise, frame_id)
        self._compare_noise(window, location, check)
        self._learn(light, camera_model)
        self._debug_image.offer(
            lambda: draw(window, noise, location, bearing, name=light),
            window.stamp_ns,
            frame_id,
        )

    def _range(
        self, light: str, window: Window, location: Location, bearing: Bearing,
        noise: SensorNoise, frame_id: str,
    ) -> None:
        """Publish how far away a light is, if its size or flux tell."""
        about = f'{light}: ' if light else ''
        try:
            disc, found = window_to_range(
                window, location, bearing, noise=noise, ranging=self._ranging
            )
        except (LocationError, RangeError) as error:
            self._health.fault(WARN, f'{target_topic(light)}: no range: {error}')
            self._health.count(f'{about}ranges refused')
            return
        self._health.show(f'{about}flux (DN)', f'{disc.flux:.6g}')
        self._health.show(f'{about}radius (px)', f'{max(disc.square, 0.0) ** 0.5:.3f}')
        if found is None:
            return
        self._ranges[light].publish(range_message(found, location.stamp_ns, frame_id))
        self._health.show(
            f'{about}range (m)', f'{found.distance:.4g} +- {found.variance ** 0.5:.2g}'
        )

    def _clipped_at(self, window: Window, info: CameraInfo) -> int:
        """Return the level at which a window's pixels are clipped, DN; 0 for full scale."""
        self._not_linear = ''
        if self._response is None:
            if window.lit.dtype == np.uint8 or not self._saturation or self._looks > 1:
                return self._saturation
            most = int(window.lit.max(initial=0))
            if most < OTHER_DEPTH * self._saturation:
                return self._saturation
            self._not_linear = (
                f'the windows hold pixels of {most} DN, and saturation is {self._saturation}: '
                'they are taken for linear, with the clipped ones at full scale; give the locator '
                'the response_url of the segmenter, or the right saturation'
            )
            return 0
        try:
            self._response.check_size(int(info.width), int(info.height))
        except CalibrationError as error:
            self._not_linear = f'{error}; its pixels are taken for linear'
            return self._saturation
        if self._looks == 1 and not self._response.has_made(window.lit):
            self._not_linear = (
                'the windows hold raw pixels and are taken for linear; give the segmenter the '
                'same response_url, or see its diagnostics'
            )
            return self._saturation
        return 0  # where the segmenter puts clipped linear pixels

    def _fit_pulse(self, camera_model: CameraModel) -> None:
        """Have the locator fit the learned pulse if it was learned with this camera."""
        if self._pulse is None:
            return
        self._no_pulse = ''
        try:
            self._pulse.check_size(camera_model.width, camera_model.height)
        except CalibrationError as error:
            self._no_pulse = str(error)
        self._locator.pulse = None if self._no_pulse else self._pulse.learned.pulse

    def _learn(self, light: str, camera_model: CameraModel) -> None:
        """Learn the light's pulse, a millisecond of it, and keep the first one that is used."""
        self._locator.learn(light)
        learner = self._locator.learners.get(light)
        if learner is None:
            return
        self._health.show(f'{light}: pulse' if light else 'pulse', learner.state)
        if learner.learned is None or self._keep_at is None:
            return
        # Neither the disk nor YAML should keep a bearing waiting.
        Thread(
            target=self._keep,
            args=(self._keep_at, learner.learned, camera_model.width, camera_model.height),
        ).start()
        self._keep_at = None

    def _keep(self, path: Path, learned: Learned, width: int, height: int) -> None:
        """Write a pulse that was learned while tracking."""
        try:
            PulseFile(learned, width, height).to_yaml(
                path, [f'learned by the locator while tracking, from {learned.windows} windows']
            )
        except CalibrationError as error:
            self._not_kept = str(error)

    def _describe(self) -> None:
        """Show in the diagnostics how the targets were placed."""
        for doubt in self._camera.doubts:
            self._health.fault(WARN, f'camera_info: {doubt}')
        with self._lock:
            for light, places in self._places.items():
                self._describe_light(f'{light}: ' if light else '', places)
            bearing = self._bearing
        if bearing is not None:
            azimuth, elevation = np.sqrt(bearing.covariance.diagonal())
            self._health.show('sigma azimuth (mrad)', f'{azimuth:.4f}')
            self._health.show('sigma elevation (mrad)', f'{elevation:.4f}')

    def _describe_light(self, name: str, places: RecentPlaces) -> None:
        """Show how one light was placed, and warn where its places scatter more than they may."""
        last = places.last
        if last is None:
            return
        sigma_x, sigma_y = np.sqrt(last.covariance.diagonal())
        found = places.scatter()
        scatter = 'unknown: there are fewer than 16 places without a gap'
        if found is not None:
            scatter = f'{found.ratio:.2f} +- {found.error:.2f}'
            if found.by_stamps > found.ratio:
                scatter += f' ({found.by_stamps:.2f} if the stamps were true, which jitter)'
            self._health.show(f'{name}jumps', found.jumps)
        for key, value in (
            ('SNR', f'{last.snr:.1f}'),
            ('chi-square', f'{last.chi2:.2f}'),
            ('chi-square mean', f'{places.chi2:.2f}'),
            ('saturated pixels', last.saturated),
            ('width of the blob, sigma (px)', f'{last.sigma:.4f}'),
            ('sigma x (px)', f'{sigma_x:.4f}'),
            ('sigma y (px)', f'{sigma_y:.4f}'),
            ('scatter / sigma', scatter),
        ):
            self._health.show(name + key, value)
        if found is None or not found.exceeds(SUSPICIOUS):
            return
        if places.chi2 > SUSPICIOUS:
            cause = (
                'and so do the pixels about their fit; measure noise.gain, noise.read_noise and '
                'noise.black_level with python3 -m blob_tracker calibrate noise'
            )
        else:
            cause = (
                'while the pixels fit; the target or the camera shakes, a pan/tilt turns it, or '
                'the method errs with the position in the pixel: compare the method '
                f'{DEFAULT_METHOD}'
            )
        self._health.fault(
            WARN,
            f'{name}the positions scatter {found.ratio:.1f} +- {found.error:.1f} times as much as '
            f'their sigmas (chi-square is {places.chi2:.1f}), {cause}',
        )

    def _compare_noise(self, window: Window, location: Location, check: NoiseCheck) -> None:
        """Warn where the configured noise is not the measured one at the target's levels."""
        if self._noise is self._configured:
            check.add(window, location)  # nobody asks it once a measured noise is in use
            if check.warning:
                self._health.fault(WARN, check.warning)
                self._health.show(
                    'noise', f'as its windows show it: {noise_in_words(check.noise)}'
                )
            elif self._by_windows:
                self._set_online(self._online)  # which shows what holds again
            self._by_windows = bool(check.warning)
            return
        levels = np.array([location.background, location.background + location.amplitude])
        ratio = variance_ratio(levels / self._looks, self._configured, self._noise)
        if not 1.0 / DIFFERENT <= ratio <= DIFFERENT:
            self._health.fault(
                WARN,
                f'the configured noise ({noise_in_words(self._configured)}) has {ratio:.2g} times '
                f'the variance of the measured one, which is used; set noise.gain, '
                f'noise.read_noise and noise.black_level to {noise_in_words(self._noise)}',
            )


def _new_file(url: str) -> Path | None:
    """Return where a pulse is to be written; None if there is a file, or no place for one."""
    try:
        path = to_path(url) if url else None
        return None if path is None or path.exists() else path
    except (ParameterError, OSError):  # no such scheme; a name that is too long for the disk
        return None


def compile_default() -> None:
    """Compile the fits, before the first target could wait for them."""
    compile_ahead([DEFAULT_METHOD])
    compile_lens()


def main() -> None:
    """Run the node."""
    sys.exit(run(lambda: [LocatorNode()], compile_default))
