"""
The rooms in a row: frames in, bearings out, no ROS.

`window_to_bearing` is the part of it that the locator node shares. What `ros2 run blob_tracker
pipeline` starts is another thing, the nodes in one process: `blob_tracker.nodes.pipeline`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from math import isfinite, prod, sqrt
from typing import NamedTuple

from blob_tracker import location, segmentation, tracking
from blob_tracker.camera import CalibrationError, CameraModel, compile_lens, LensError
from blob_tracker.camera.light_range import (
    angle_per_pixel, combined, LightRange, range_by_flux, range_by_size, RangeError, Ranging,
)
from blob_tracker.camera.line_jitter import LineJitter
from blob_tracker.camera.response import Response
from blob_tracker.location import EffectivePsf, Learned, Locator, method_options, METHODS
from blob_tracker.location.disc import Disc, fit_disc
from blob_tracker.location.noise_check import NoiseCheck
from blob_tracker.segmentation import Expectation, FieldSegmenter, FrameError, Segmenter
from blob_tracker.segmentation.registration import compile_registration
from blob_tracker.tracking import Track, Tracker, TrackingError, update_or_restart
from blob_tracker.types import Bearing, Frame, Location, LocationError, SensorNoise, Window

# Each brings the time of a line nearer by the light's speed over the shutter's: 1/50 if it crosses
# the picture in a second, and is read in 20 ms.
ROUNDS = 3
PART_OF_FLUX = (
    'the light was on for a part of the exposure that is known too coarsely for its flux to give '
    'the range: have the camera switch it by wire, in mode alternate, or give range.diameter'
)

SUM_OF_FLUXES = (
    'the window is a sum of frames (looks, or mode lock_in), and for how long the light was on in '
    'each is not known: for a range by flux sum none, or give range.diameter'
)


def compile_ahead(methods: Iterable[str] = tuple(METHODS)) -> None:
    """
    Compile the loops over pixels of all rooms, or load them from Numba's cache.

    Parameters
    ----------
    methods : iterable of str
        Location methods, keys of `blob_tracker.location.METHODS`; all of them if left out.

    """
    location.compile_ahead(methods)
    compile_lens()
    segmentation.compile_ahead()
    compile_registration()
    tracking.compile_ahead()


def expectation(track: Track, camera_model: CameraModel) -> Expectation | None:
    """
    Return where in the picture a target is expected.

    Parameters
    ----------
    track : Track
        As the camera sees the target at the frame's stamp.
    camera_model : CameraModel
        The camera.

    Returns
    -------
    Expectation or None
        With the covariance of the angles, carried through the derivative of the place; None if
        the lens has no picture of that direction.

    Examples
    --------
    A direction 100 mrad to the right of the axis, known to 1 mrad, in a lens of 600 px:

    >>> import numpy as np
    >>> from blob_tracker.camera import pinhole_matrix
    >>> model = CameraModel(640, 480, pinhole_matrix(600.0, 640, 480))
    >>> track = Track(0, np.array([100.0, 0.0, 0.0, 0.0]), np.eye(4))
    >>> expected = expectation(track, model)
    >>> round(expected.x, 1), round(float(expected.covariance[0, 0] ** 0.5), 2)  # px
    (379.7, 0.61)

    """
    try:
        x, y, derivative = camera_model.place(track.azimuth, track.elevation)
    except LensError:
        return None
    return Expectation(x, y, derivative @ track.angle_covariance @ derivative.T)


def expectation_in(
    frame: Frame, seen_at: Callable[[int], Track | None], camera_model: CameraModel
) -> Expectation | None:
    """
    Return where in a frame a target is expected, when the line is exposed in which it lies then.

    Parameters
    ----------
    frame : Frame
        Its stamp is that of the first line.
    seen_at : callable
        Returns the track as the camera sees the target at a stamp, ns; None if there is none.
    camera_model : CameraModel
        The camera.

    Examples
    --------
    A light that falls by 100 mrad/s before a rolling shutter of 50 us a line; the line in which it
    is seen is exposed 13.5 ms after the first:

    >>> import numpy as np
    >>> from blob_tracker.camera import pinhole_matrix
    >>> model = CameraModel(640, 480, pinhole_matrix(600.0, 640, 480))
    >>> def seen_at(stamp_ns):
    ...     state = np.array([0.0, -50.0 - 1e-7 * stamp_ns, 0.0, -100.0])
    ...     return Track(stamp_ns, state, np.eye(4))
    >>> frame = Frame(np.zeros((480, 640), np.uint8), 0, saturation=255, line_time_ns=50_000.0)
    >>> round(expectation_in(frame, seen_at, model).y, 1)  # px
    270.3
    >>> round(expectation(seen_at(0), model).y, 1)
    269.5

    """
    stamp_ns = frame.stamp_ns
    expected = None
    for _ in range(ROUNDS):
        track = seen_at(stamp_ns)
        expected = None if track is None else expectation(track, camera_model)
        if expected is None or not frame.line_time_ns or not isfinite(expected.y):
            break
        stamp_ns = frame.stamp_ns + round(expected.in_frame(frame).y * frame.line_time_ns)
    return expected


def window_to_bearing(
    window: Window,
    camera_model: CameraModel,
    *,
    locator: Locator,
    noise: SensorNoise,
    line_jitter: LineJitter | None = None,
    light: str = '',
    check: NoiseCheck | None = None,
) -> tuple[Location, Bearing]:
    """
    Locate the blob of a window, take the jitter of its line off, and turn it into an angle.

    Parameters
    ----------
    window : Window
        Lit and unlit pixels, DN.
    camera_model : CameraModel
        The calibrated camera.
    locator : Locator
        Has the method, and remembers the last flashes of the light.
    noise : SensorNoise
        Gain and read noise of the camera's pixels.
    line_jitter : LineJitter, optional
        Offsets of the lines of an analogue grabber.
    light : str
        Name of the light.
    check : NoiseCheck, optional
        Has seen the last windows of the light, and doubts this one by them.

    Returns
    -------
    location : Location
        px of the full frame, without the jitter.
    bearing : Bearing
        mrad.

    Raises
    ------
    LocationError
        If there is no blob that can be placed.
    CalibrationError
        If the line jitter is for a picture of another height.
    LensError
        If no ray leads to that place in the picture.

    Examples
    --------
    >>> import numpy as np
    >>> from blob_tracker.camera import pinhole_matrix
    >>> from blob_tracker.simulation import pixel_integrated_gaussian
    >>> model = CameraModel(640, 480, pinhole_matrix(600.0, 640, 480))
    >>> pulse = 40.0 + 150.0 * pixel_integrated_gaussian((15, 15), 7.0, 7.0, 2.0)
    >>> window = Window(pulse.round().astype(np.uint8), x0=372, y0=232, saturation=255)
    >>> noise = SensorNoise(gain=40.0, read_noise=0.7)
    >>> location, bearing = window_to_bearing(window, model, locator=Locator(), noise=noise)
    >>> round(location.x, 2), round(bearing.azimuth, 1)  # px, mrad
    (379.0, 98.8)

    """
    location = locator.locate(window, noise=noise, light=light)
    if check is not None:
        location = check.doubted(window, location)
    if line_jitter is not None:
        line_jitter.check_height(camera_model.height)
        location = line_jitter.corrected(
            location, gain=noise.gain, looks=window.looks, field=window.field
        )
    return location, camera_model.bearing(location)


def window_to_range(
    window: Window,
    location: Location,
    bearing: Bearing,
    *,
    noise: SensorNoise,
    ranging: Ranging,
) -> tuple[Disc, LightRange | None]:
    """
    Tell how large and bright a light is, and how far away that makes it.

    Parameters
    ----------
    window : Window
        Lit and unlit pixels, DN.
    location, bearing : Location, Bearing
        What `window_to_bearing` has made of it.
    noise : SensorNoise
        Of the camera.
    ranging : Ranging
        What is known of the light.

    Returns
    -------
    disc : Disc
        Size and flux in the picture.
    light_range : LightRange or None
        By what tells it of size and flux, or both; None if neither is known. Flux tells
        nothing where the window has a `Glimpse`: it is that of a part of the exposure; nor where
        it is a sum of frames, whose parts nobody knows.

    Raises
    ------
    LocationError
        If no disc fits the light.
    RangeError
        If neither tells the range, or they contradict each other.

    Examples
    --------
    A light whose flux was 15080 DN at 10 m, and now is 2 pi sigma^2 150 DN, a quarter of it:

    >>> import numpy as np
    >>> from blob_tracker.camera import pinhole_matrix
    >>> from blob_tracker.simulation import pixel_integrated_gaussian
    >>> model = CameraModel(640, 480, pinhole_matrix(600.0, 640, 480))
    >>> pulse = 40.0 + 150.0 * pixel_integrated_gaussian((17, 17), 8.0, 8.0, 2.0)
    >>> window = Window(pulse.round().astype(np.uint8), x0=372, y0=232, saturation=255)
    >>> noise = SensorNoise(gain=40.0, read_noise=0.7)
    >>> seen = window_to_bearing(window, model, locator=Locator(), noise=noise)
    >>> ranging = Ranging(psf_sigma=2.0, reference_distance=10.0, reference_flux=15080.0)
    >>> disc, light_range = window_to_range(window, *seen, noise=noise, ranging=ranging)
    >>> round(light_range.distance, 1)  # m
    20.0

    """
    disc = fit_disc(window, location, noise=noise, psf_sigma=ranging.psf_sigma)
    by_size = by_flux = None
    refusals = []
    if ranging.diameter > 0.0:
        pixel = sqrt(prod(window.binning)) * angle_per_pixel(location, bearing)
        try:
            by_size = range_by_size(
                disc.square, disc.covariance[0, 0], pixel=pixel, diameter=ranging.diameter,
                psf_sigma=ranging.psf_sigma, calibration_sigma=ranging.calibration_sigma,
            )
        except RangeError as error:
            refusals.append(str(error))
    if ranging.reference_flux > 0.0:
        try:
            by_flux = _range_by_flux(window, disc, ranging)
        except RangeError as error:
            refusals.append(str(error))
    if by_size is not None and by_flux is not None:
        return disc, combined(
            by_size, by_flux, disc.covariance[0, 1] / (4.0 * disc.square * disc.flux))
    found = by_size or by_flux
    if found is None and refusals:
        raise RangeError('; '.join(refusals))
    return disc, found


def _range_by_flux(window: Window, disc: Disc, ranging: Ranging) -> LightRange:
    """Return the range by the flux of a window, if that is of a whole exposure."""
    if window.glimpse is not None:
        raise RangeError(PART_OF_FLUX)
    if window.looks > 1:
        raise RangeError(SUM_OF_FLUXES)
    return range_by_flux(
        disc.flux, disc.covariance[1, 1],
        reference_distance=ranging.reference_distance, reference_flux=ranging.reference_flux,
        calibration_sigma=ranging.calibration_sigma,
    )


class Placed(NamedTuple):
    """
    A light that was seen in a frame, and where.

    Parameters
    ----------
    light : str
        Its name; '' of one without.
    location : Location
        px of the full frame.
    bearing : Bearing
        mrad.

    Examples
    --------
    >>> import numpy as np
    >>> location = Location(379.5, 239.5, 1e-4 * np.eye(2), 150.0, 40.0, 2.0, 50.0, 1.0, 0)
    >>> placed = Placed('port', location, Bearing(99.7, 0.0, 3e-4 * np.eye(2)))
    >>> placed.light, placed.bearing.azimuth  # mrad
    ('port', 99.7)

    """

    light: str
    location: Location
    bearing: Bearing


class Pipeline:
    """
    Track flashing lights, frame by frame in the caller's thread.

    The numbers are those of the nodes; see `blob_tracker.nodes.pipeline` for these.

    Parameters
    ----------
    camera_model : CameraModel
        The calibrated camera.
    noise : SensorNoise
        Gain and read noise of its pixels.
    method : str
        Location method, a key of `blob_tracker.location.METHODS`.
    elliptical : bool
        Fit a width along x and one along y, for the methods that have both forms.
    segmenter : Segmenter or FieldSegmenter, optional
        Finds the flash; one with default settings where it is left out. Its `reason` tells why
        the last frame gave no bearing.
    line_jitter : LineJitter, optional
        Offsets of the lines of an analogue grabber, to be taken off each location.
    response : Response, optional
        Of a camera whose pixels are not proportional to the light, as `calibrate response`
        measures it: frames are made linear as they come, and `noise`, `pulse` and the DN of all
        that is found are those of linear pixels.
    pulse : EffectivePsf, optional
        Learned pulse to fit in place of the Gaussian, see `learn_pulse`.
    learn : bool
        Learn the pulse while tracking, and fit it once it has been shown to be better. It takes
        a millisecond of each flash, when the bearing has been yielded; see
        `blob_tracker.location.pulse_learner`.
    tracker : Tracker, optional
        Takes each bearing of the light without a name, and tells the segmenter where to look for
        the next one. What it refuses is a bearing all the same.

    Attributes
    ----------
    warning : str
        What is not as it should be about the last bearing, and what to do; '' where all is well.
        Where the unlit pixels show another noise than `noise`, that is used instead; see
        `blob_tracker.location.noise_check`.

    Raises
    ------
    ValueError
        If there is no such method, or it has no elliptical form or takes no pulse.
    CalibrationError
        If the line jitter is for a picture of another height, or the response for one of
        another size.

    Examples
    --------
    Frames of the virtual lab, in every other of which the light is on:

    >>> from blob_tracker.camera import CameraModel, pinhole_matrix
    >>> from blob_tracker.simulation import flashing_light
    >>> scene = flashing_light()
    >>> height, width = scene.frame(0).shape
    >>> model = CameraModel(width, height, pinhole_matrix(600.0, width, height))
    >>> pipeline = Pipeline(model, noise=SensorNoise(gain=40.0, read_noise=0.7))
    >>> frames = (
    ...     Frame(scene.frame(index), stamp_ns=16_666_667 * index, saturation=255)
    ...     for index in range(20)
    ... )
    >>> bearings = list(pipeline.run(frames))
    >>> len(bearings) >= 6
    True

    """

    def __init__(
        self,
        camera_model: CameraModel,
        *,
        noise: SensorNoise,
        method: str = 'maximum_likelihood',
        elliptical: bool = False,
        segmenter: Segmenter | FieldSegmenter | None = None,
        line_jitter: LineJitter | None = None,
        response: Response | None = None,
        pulse: EffectivePsf | None = None,
        learn: bool = False,
        tracker: Tracker | None = None,
    ) -> None:
        if line_jitter is not None:
            line_jitter.check_height(camera_model.height)
        if response is not None:
            response.check_size(camera_model.width, camera_model.height)
        self.camera_model = camera_model
        self.method = method
        self.segmenter: Segmenter | FieldSegmenter = segmenter or FieldSegmenter(Segmenter)
        self.line_jitter = line_jitter
        self.response = response
        self.tracker = tracker
        self.warning = ''
        self._locator = Locator(
            method, learn=learn, **method_options(method, elliptical=elliptical, pulse=pulse)
        )
        self._noise = noise
        self._noise_checks: dict[str, NoiseCheck] = {}

    @property
    def learned(self) -> Learned | None:
        """Return the pulse that was learned and is fitted; None if there is none."""
        return next((each.learned for each in self._locator.learners.values()), None)

    @property
    def learning(self) -> str:
        """Return how far learning the pulse is, in words; '' where none is to be learned."""
        return next((each.state for each in self._locator.learners.values()), '')

    @property
    def noise(self) -> SensorNoise:
        """Gain and read noise of the pixels, as configured; it may be set at any time."""
        return self._noise

    @noise.setter
    def noise(self, noise: SensorNoise) -> None:
        self._noise = noise
        for check in self._noise_checks.values():
            check.configure(noise)

    def run(self, frames: Iterable[Frame]) -> Iterator[Bearing]:
        """
        Yield a bearing for each frame in which the target lit up and could be placed.

        Of several lights it yields those of all, see `named`.

        Parameters
        ----------
        frames : iterable of Frame
            In the order of their stamps; one that is late or comes twice is left out.

        Yields
        ------
        Bearing
            With the stamp of the instant at which the light was seen, see `Location`.

        Raises
        ------
        CalibrationError
            If a frame is larger than the picture that was calibrated, or its pixels are not
            those that the response is for.

        """
        for _, bearing in self.named(frames):
            yield bearing

    def named(self, frames: Iterable[Frame]) -> Iterator[tuple[str, Bearing]]:
        """Yield the name of a light with each of its bearings, else as `run` does."""
        for frame in frames:
            for light, _, bearing in self.placed(frame):
                yield light, bearing

    def placed(self, frame: Frame) -> Iterator[Placed]:
        """
        Yield the lights that the next frame shows, each with its place in the picture.

        Where there is none, `segmenter.reason` tells why; errors are those of `run`.
        """
        self._check_size(frame)
        if self.response is not None:
            frame = self.response.linear_frame(frame)
        try:
            sightings = self.segmenter.sightings(frame, self._expected(frame))
        except FrameError as error:
            self.segmenter.reason = str(error)  # silence, never a wrong angle
            return
        for light, window in sightings:
            try:
                location, bearing = self._bearing(light, window)
            except (LocationError, LensError) as error:
                self.segmenter.reason = str(error)
                continue
            if not light:
                self._track(bearing)
            yield Placed(light, location, bearing)
            self._locator.learn(light)

    def _bearing(self, light: str, window: Window) -> tuple[Location, Bearing]:
        """Return where a window's blob is, and hold the noise of its pixels against what it is."""
        if light not in self._noise_checks:
            self._noise_checks[light] = NoiseCheck(self._noise)
        check = self._noise_checks[light]
        location, bearing = window_to_bearing(
            window,
            self.camera_model,
            locator=self._locator,
            noise=check.noise,
            line_jitter=self.line_jitter,
            light=light,
            check=check,
        )
        check.add(window, location)
        self.warning = location.warning or check.warning
        return location, bearing

    def _expected(self, frame: Frame) -> Expectation | None:
        """Return where the tracker expects the target in a frame."""
        if self.tracker is None:
            return None
        return expectation_in(frame, self.tracker.seen_at, self.camera_model)

    def _track(self, bearing: Bearing) -> None:
        """Have the tracker take a bearing; restart it where the stamps jumped back."""
        tracker = self.tracker
        if tracker is None:
            return
        try:
            update_or_restart(lambda: tracker.update(bearing), lambda jump: tracker.reset())
        except TrackingError:
            pass  # what it keeps is the better one; three in a row that agree are believed

    def _check_size(self, frame: Frame) -> None:
        """Refuse a frame that the calibration does not cover."""
        height, width = frame.image.shape[:2]
        right, bottom = frame.x0 + width * frame.binning[0], frame.y0 + height * frame.binning[1]
        if right > self.camera_model.width or bottom > self.camera_model.height:
            raise CalibrationError(
                f'the frame reaches to ({right}, {bottom}) px and the calibration is for '
                f'{self.camera_model.width} x {self.camera_model.height} px'
            )
