"""
One search for the exposure and gain at which the target is bright and not clipped.

The lit peak is brought to 70 % of full scale: the error of a place falls with the square root of
the light, and what is clipped says nothing about it. Light is exposed for before it is amplified,
as gain raises the noise with the signal: exposure first, up to half the frame interval, then gain.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
import time
from typing import Protocol

from blob_tracker.capture import auto_modes, videodev2
from blob_tracker.capture.controls import Control, ControlError
from blob_tracker.capture.errors import CaptureError
from blob_tracker.capture.exposure_search import Outcome, Scale, search, Setting, TARGET, TOLERANCE
from blob_tracker.colour import AUTO, channels, in_channel
from blob_tracker.types import Frame, Pixels
import cv2
import numpy as np

# A pulse of sigma 0.74 px that falls onto the middle of a pixel has 0.4 of it beside it, a hot
# pixel nothing.
ABOVE_NEIGHBOUR = 2.5


class Adjustable(Protocol):
    """What a search needs of a camera; `V4l2Camera` has it."""

    frame_rate: float

    @property
    def controls(self) -> dict[str, Control]:
        """Return the controls by name."""

    @property
    def exposure_unit(self) -> float | None:
        """Return one unit of the exposure control, s; None if it is unknown."""

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
