"""
One search for the exposure and gain at which the target is bright and not clipped.

The lit peak is brought to 70 % of full scale: the error of a place falls with the square root of
the light, and what is clipped says nothing about it. Light is exposed for before it is amplified,
as gain raises the noise with the signal: exposure first, up to half the frame interval, then gain.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from math import log, sqrt
import time
from typing import Protocol

from blob_tracker.capture import auto_modes, videodev2
from blob_tracker.capture.controls import Control, ControlError
from blob_tracker.capture.errors import CaptureError
from blob_tracker.colour import AUTO, channels, in_channel
from blob_tracker.types import Frame, Pixels
import cv2
import numpy as np

TARGET = 0.7  # of full scale
# A target that comes nearer by a seventh stays unclipped at the upper end; at the lower one the
# error of a place, which goes with 1 / sqrt(light), is 4 % above that at the middle.
TOLERANCE = 0.05  # of full scale
CLIPPED = 0.99  # of full scale: 8-bit cameras differ in which of the last codes they reach
FASTEST = 8.0  # the most that a faint peak, which is mostly noise, multiplies the exposure by
# A pulse of sigma 0.74 px that falls onto the middle of a pixel has 0.4 of it beside it, a hot
# pixel nothing.
ABOVE_NEIGHBOUR = 2.5


@dataclass(frozen=True)
class Scale:
    """
    The values that a control may take.

    Parameters
    ----------
    minimum, maximum, step : int
        In units of the control.

    """

    minimum: int
    maximum: int
    step: int = 1

    @property
    def top(self) -> int:
        """Return the index of the greatest value; that of `minimum` is 0."""
        return (self.maximum - self.minimum) // self.step

    def value(self, index: int) -> int:
        """Return the value of an index."""
        return self.minimum + index * self.step

    def index(self, value: float) -> int:
        """Return the index of the greatest value that is not above `value`, within the scale."""
        return min(max(int((value - self.minimum) // self.step), 0), self.top)


@dataclass(frozen=True)
class Outcome:
    """
    What a search came to.

    Parameters
    ----------
    exposure, gain : int or None
        The values to leave the controls at; None where there is no such control.
    peak : float
        The lit peak there, of full scale.
    found : bool
        Whether the peak lies within the tolerance of the target.
    words : str
        The same in a sentence.
    controls : mapping of str to int
        What a search on a camera set, by the control's name: the automatic modes that it
        switched off, exposure and gain.

    """

    exposure: int | None
    gain: int | None
    peak: float
    found: bool
    words: str
    controls: Mapping[str, int] = field(default_factory=dict)


Setting = tuple[int | None, int | None]  # exposure, gain


def search(
    exposure: Scale | None,
    gain: Scale | None,
    start: int = 0,
    target: float = TARGET,
    tolerance: float = TOLERANCE,
) -> Generator[Setting, float, Outcome]:
    """
    Yield settings (exposure, gain); be sent the lit peak that each gives; return the outcome.

    The peak is taken to grow with both, and nothing more: a black level, gain in decibels and
    coarse steps do no harm. Each control is followed by the secant while all that was seen is too
    dark, halved while the peak is clipped, and bracketed from then on.

    Parameters
    ----------
    exposure, gain : Scale or None
        What the controls may be; None where there is none.
    start : int
        Exposure to begin with; gain begins at its minimum.
    target, tolerance : float
        Of full scale. The peak sent is in the same unit, `CLIPPED` and above being clipped.

    """
    at: list[int | None] = [None, gain.minimum if gain else None]
    peak = 0.0
    for place, scale in enumerate((exposure, gain)):
        if scale is None:
            continue
        begin = scale.index(start) if place == 0 else 0
        known = None
        if place == 1 and exposure is not None:
            known = peak  # measured at the least gain already
        seek = _seek(scale, begin, known, place == 0, target, tolerance)
        try:
            at[place] = scale.value(next(seek))
            while True:
                peak = yield at[0], at[1]
                at[place] = scale.value(seek.send(peak))
        except StopIteration as end:
            index, peak = end.value
            at[place] = scale.value(index)
        if peak > target - tolerance:
            break  # as it should be, or too bright, which gain makes no better
    found = abs(peak - target) <= tolerance
    return Outcome(at[0], at[1], peak, found, _words(exposure, gain, at, peak, target, found))


def _words(
    exposure: Scale | None, gain: Scale | None, at: list[int | None], peak: float, target: float,
    found: bool,
) -> str:
    at_peak = f'the lit peak is at {100 * peak:.0f} % of full scale'
    if found:
        return at_peak
    scales = [(scale, value) for scale, value in ((exposure, at[0]), (gain, at[1])) if scale]
    if peak > target and all(value == scale.minimum for scale, value in scales):
        return (f'too bright: {at_peak} with exposure and gain at their least; close the aperture '
                'or put a filter in front of the lens')
    if peak < target and all(value == scale.value(scale.top) for scale, value in scales):
        return (f'too dark: {at_peak} with exposure and gain at their most; open the aperture, '
                'bring more light or allow a longer exposure')
    return f'{at_peak}: the nearest to {100 * target:.0f} % that the steps of the controls allow'


def _seek(
    scale: Scale, index: int, peak: float | None, proportional: bool, target: float,
    tolerance: float,
) -> Generator[int, float, tuple[int, float]]:
    """
    Yield indices; be sent their peaks; return the first index that will do, with its peak.

    Where none does: an end of the scale, or of two neighbours the one that is too dark, for the
    gain to add the rest; of the gain, the nearer.
    """
    dark: list[tuple[int, float]] = []  # too dark, too bright: (index, peak), the latest last
    bright: list[tuple[int, float]] = []
    while True:
        if peak is None:
            peak = yield index
        if abs(peak - target) <= tolerance:
            return index, peak
        (dark if peak < target else bright).append((index, peak))
        if index == (scale.top if peak < target else 0):
            return index, peak
        if not bright:
            index = _brighter(scale, dark, proportional, target)
        elif not dark:
            index //= 2
        elif bright[-1][0] - dark[-1][0] > 1:
            index = _between(dark, bright, proportional, target)
        elif proportional:
            return dark[-1]
        else:
            return min(dark[-1], bright[-1], key=lambda seen: abs(seen[1] - target))
        peak = None


def _brighter(
    scale: Scale, dark: list[tuple[int, float]], proportional: bool, target: float,
) -> int:
    """Return a greater index where all that was seen is too dark."""
    index, peak = dark[-1]
    if not proportional:
        return (index + scale.top + 1) // 2
    value = scale.value(index)
    most = max(FASTEST * value, float(scale.value(index + 1)))
    wanted = value * target / peak if peak > 0.0 else most
    if len(dark) > 1:  # the slope leaves the black level out, which the proportion cannot
        rise = peak - dark[-2][1]
        run = value - scale.value(dark[-2][0])
        wanted = value + (target - peak) * run / rise if rise > 0.0 else most
    return max(index + 1, scale.index(min(wanted, most)))


def _between(
    dark: list[tuple[int, float]], bright: list[tuple[int, float]], proportional: bool,
    target: float,
) -> int:
    """Return an index between the nearest that is too dark and the nearest that is too bright."""
    (low, low_peak), (high, high_peak) = dark[-1], bright[-1]
    # Light comes in proportion to the exposure and, mostly, to the exponential of the gain.
    if (high_peak >= CLIPPED or low_peak <= 0.0 or (len(dark) + len(bright)) % 2):
        # Every second time, so that an uneven response cannot make it creep.
        middle = sqrt((low + 1) * (high + 1)) - 1 if proportional else (low + high) / 2
    elif proportional:
        middle = low + (high - low) * (target - low_peak) / (high_peak - low_peak)
    else:
        middle = low + (high - low) * log(target / low_peak) / log(high_peak / low_peak)
    return min(max(round(middle), low + 1), high - 1)


# --- on a camera ---


class Adjustable(Protocol):
    """What a search needs of a camera; `V4l2Camera` has it."""

    frame_rate: float

    @property
    def controls(self) -> dict[str, Control]:
        """Return the controls by name."""

    @property
    def exposure_unit(self) -> float | None:
        """Return one unit of the exposure control, s; None where it is unknown."""

    def get_control(self, name: str) -> int | str:
        """Return the value of a control."""

    def set_control(self, name: str, value: int | bool | float | str) -> None:
        """Set a control."""


def put_back(camera: Adjustable, before: Mapping[str, int | str]) -> None:
    """
    Undo what was set, the last first, as the first may be what made the others possible.

    What is refused is tried again after the rest, and left as it is where that does not help.

    Parameters
    ----------
    camera : V4l2Camera
        Open.
    before : mapping of str to int or str
        Value by the control's name, in the order in which the controls were set.

    Raises
    ------
    CaptureError
        The camera is gone.

    """
    pending = list(before)[::-1]
    while pending:
        refused = []
        for name in pending:
            try:
                camera.set_control(name, before[name])
            except ControlError:
                refused.append(name)
        if refused == pending:
            return
        pending = refused


def peak_of_channel(frame: Frame, channel: str) -> float:
    """
    Return the lit peak of a frame in a channel, of full scale.

    Parameters
    ----------
    frame : Frame
        Grey, or with colours.
    channel : str
        One of `blob_tracker.colour.CHANNELS`; 'auto' is the colour in which it is highest: none
        is clipped then. A grey frame has one channel, whatever this is.

    """
    names = channels(frame)
    if not names:
        return lit_peak(frame.image) / frame.saturation
    if channel != AUTO:
        names = (channel,)
    peaks = []
    for name in names:
        one = in_channel(frame, name)
        if one.mosaic is not None:
            for row, column in np.argwhere(one.mosaic.sites):
                plane = np.ascontiguousarray(one.samples[row::2, column::2])
                peaks.append(lit_peak(plane) / one.sample_saturation)
        else:
            peaks.append(lit_peak(one.image) / one.saturation)
    return max(peaks)


def lit_peak(image: Pixels) -> float:
    """
    Return the brightest of a picture's pixels, DN, but no hot ones.

    A pixel counts for at most `ABOVE_NEIGHBOUR` times the brightest of its eight neighbours.
    """
    around = np.ones((3, 3), np.uint8)
    around[1, 1] = 0
    beside = cv2.dilate(image, around)
    return float(np.minimum(image, ABOVE_NEIGHBOUR * beside).max())


def adjust_exposure(
    camera: Adjustable,
    read: Callable[[], Frame],
    *,
    longest: float | None = None,
    exposure: str = '',
    gain: str = '',
    target: float = TARGET,
    tolerance: float = TOLERANCE,
    frames: int = 12,
    settling: int = 3,
    channel: str = AUTO,
) -> Outcome:
    """
    Search on a streaming camera, and leave its controls at the outcome.

    Automatic exposure and gain are switched off first, but for those that are inactive. Where the
    search cannot be finished the controls get the values again that they had. The target has to
    be in view and the brightest thing there: the lit peak is the greatest `peak_of_channel` of a
    row of frames.

    Parameters
    ----------
    camera : V4l2Camera
        Streaming.
    read : function
        Returns its next frame: `camera.read`, or `newest` of the grabber that reads it.
    longest : float or None
        Longest exposure, s; None is half the frame interval, which leaves the other half to a
        flash that is not in step. Where the driver does not tell the frame rate or the unit of
        its exposure the control's own range is the limit.
    exposure, gain : str
        The controls to use; '' takes the standard ones of the kernel.
    target, tolerance : float
        Of full scale.
    frames : int
        Frames that are looked at for each setting, so many that the light is on in four of them
        or more: 12 for a light that flashes at half the frame rate leaves room for lost frames.
    settling : int
        Frames left out after a change, beside those taken before it: sensors have the next one
        or two in work already.
    channel : str
        The colour of the light, see `peak_of_channel`.

    Returns
    -------
    Outcome
        Look at `found` and `words`.

    Raises
    ------
    ControlError
        The device has neither exposure nor gain control.
    CaptureError
        The device fails meanwhile.

    """
    found = camera.controls
    exposures = _control(found, exposure, videodev2.CID_EXPOSURE_ABSOLUTE, videodev2.CID_EXPOSURE)
    gains = _control(found, gain, videodev2.CID_ANALOGUE_GAIN, videodev2.CID_GAIN)
    if exposures is None and gains is None:
        raise ControlError('the device has no control for exposure or gain; its controls are '
                           + (', '.join(sorted(found)) or 'none'))
    modes = auto_modes.off(found)
    before: dict[str, int | str] = {}
    for name in (*modes, *(each.name for each in (exposures, gains) if each is not None)):
        with suppress(ControlError):  # write-only: nobody knows what to put back
            before[name] = camera.get_control(name)
    try:
        changed = {}
        for name, value in modes.items():
            # Asked for anew, as one mode may govern another.
            if before.get(name) != value and not camera.controls[name].inactive:
                camera.set_control(name, value)
                changed[name] = value
        outcome = _searched(
            camera, exposures, gains, longest, not exposure, target, tolerance,
            lambda: _measured(read, frames, settling, channel))
    except BaseException:
        with suppress(CaptureError):  # it is gone, which the first error says
            put_back(camera, before)
        raise
    for control, setting in ((exposures, outcome.exposure), (gains, outcome.gain)):
        if control is not None and setting is not None:
            changed[control.name] = setting
    return replace(outcome, controls=changed)


def _searched(
    camera: Adjustable,
    exposures: Control | None,
    gains: Control | None,
    longest: float | None,
    standard: bool,
    target: float,
    tolerance: float,
    measure: Callable[[], float],
) -> Outcome:
    """Search with these controls, the automatic modes being off; leave them at the outcome."""
    if longest is None and camera.frame_rate > 0.0:
        longest = 0.5 / camera.frame_rate
    start = 0
    scale = None
    if exposures is not None:
        scale = _scale(exposures)
        if longest is not None and camera.exposure_unit is not None and standard:
            most = scale.value(scale.index(longest / camera.exposure_unit))
            scale = Scale(scale.minimum, most, scale.step)
        start = int(camera.get_control(exposures.name))
    course = search(scale, None if gains is None else _scale(gains), start, target, tolerance)
    try:
        setting = next(course)
        while True:
            _apply(camera, exposures, gains, setting)
            setting = course.send(measure())
    except StopIteration as end:
        outcome: Outcome = end.value
    _apply(camera, exposures, gains, (outcome.exposure, outcome.gain))
    return outcome


def _control(found: dict[str, Control], name: str, *numbers: int) -> Control | None:
    """Return the control of a name, or else the first of these numbers that there is."""
    if name:
        if name not in found:
            raise ControlError(f"there is no control '{name}'; there are "
                               + (', '.join(sorted(found)) or 'none'))
        return found[name]
    by_number = {control.number: control for control in found.values()}
    return next((by_number[number] for number in numbers if number in by_number), None)


def _scale(control: Control) -> Scale:
    return Scale(control.minimum, control.maximum, control.step)


def _apply(
    camera: Adjustable, exposures: Control | None, gains: Control | None, setting: Setting,
) -> None:
    for control, value in zip((exposures, gains), setting):
        if control is not None and value is not None:
            camera.set_control(control.name, value)


def _measured(
    read: Callable[[], Frame], frames: int, settling: int, channel: str
) -> float:
    """Return the lit peak of the frames that come after now, of full scale."""
    changed_ns = time.time_ns()
    frame = read()
    while frame.stamp_ns < changed_ns:  # waited in a buffer
        frame = read()
    for _ in range(settling):
        frame = read()
    peak = 0.0
    for _ in range(frames):
        peak = max(peak, peak_of_channel(frame, channel))
        frame = read()
    return peak
