"""What stands in the way of a stream, by the step that failed and its errno, with the remedy."""

from __future__ import annotations

import errno
import os
from typing import Literal

LOOPBACK = 'v4l2 loopback'  # name of the driver of v4l2loopback
Step = Literal['settings', 'buffers', 'stream']

# What a driver does not do where nothing better is known of its errno.
_STEPS: dict[Step, str] = {
    'settings': 'take these settings', 'buffers': 'give its buffers', 'stream': 'begin to stream',
}
_SILENT = (errno.EIO, errno.EPIPE, errno.EPROTO, errno.ETIMEDOUT, errno.EREMOTEIO, errno.ENXIO)
_NO_ANSWER = (
    'the camera does not answer ({reason}); plug it in again, with another cable or at another '
    "port; 'dmesg' says more"
)
_AT: dict[tuple[Step, int], str] = {
    ('settings', errno.EINVAL):
        'the driver refuses the size or the pixel format; set width, height and pixel_format to '
        "what 'v4l2-ctl -d {device} --list-formats-ext' lists",
    ('buffers', errno.ENOMEM):
        'there is no memory for its buffers; lower width, height or buffers (on a Raspberry Pi or '
        'another small computer they come from the CMA: cma=256M on the command line of its '
        'kernel makes it larger)',
    ('stream', errno.ENOSPC):
        'its USB bus has no bandwidth left, which another camera on the same hub or controller '
        'takes; choose a smaller width and height, a lower frame_rate or pixel_format MJPG for '
        "either, or give it a port of another controller ('lsusb -t' shows which there are)",
    ('stream', errno.EPIPE):
        'the links or formats between its sensor and this device do not fit each other (media '
        "controller); 'media-ctl -p' shows them: set the format of each pad, up to this device, "
        'to the same size and to the code of pixel_format with media-ctl --set-v4l2, and do the '
        'same on every other enabled path from its sensor, up to the other video devices '
        '(v4l2-ctl --set-fmt-video)',
    ('stream', errno.ENOLINK):
        'no sensor is linked to it; enable the link with media-ctl --links '
        "('media-ctl -p' shows them), and check the cable of the sensor and its overlay or device "
        'tree',
    ('stream', errno.EINVAL):
        'the driver refuses to begin with these settings; raise buffers, or leave width, height '
        "and pixel_format to the driver; if the sensor is behind a media controller ('media-ctl "
        "-p' shows it) its format must be the same as here; 'dmesg' says more",
    ('stream', errno.EIO):
        'there is no signal, or the camera does not answer; check the source, the cable and the '
        "port; 'dmesg' says more",
    ('stream', errno.ENOMEM):
        'there is no memory for the transfers; lower width, height or buffers',
}


def refusal(device: str, driver: str, step: Step, error: OSError) -> str:
    """
    Return why a device does not stream, and what to do.

    Parameters
    ----------
    device : str
        Its path.
    driver : str
        Name of its driver.
    step : str
        What failed: its settings, its buffers, or the beginning of the stream.
    error : OSError
        Of the driver.

    """
    code = error.errno or 0
    if driver == LOOPBACK and code in (errno.EINVAL, errno.EIO, errno.ENODATA, errno.EAGAIN):
        return no_writer(device)
    if code == errno.ENODEV:
        return unplugged(device)
    if code == errno.EBUSY:
        return busy(device, chosen=step == 'settings')
    words = _AT.get((step, code))
    if words is None and code in _SILENT:
        words = _NO_ANSWER
    if words is None:
        words = (f'the driver does not {_STEPS[step]}: {{reason}}; open it again, and if that '
                 "does not help see what 'dmesg' says")
    return f'{device}: ' + words.format(device=device, reason=os.strerror(code))


def busy(device: str, chosen: bool = False) -> str:
    """
    Return the sentence for a device that another program has.

    Parameters
    ----------
    device : str
        Its path.
    chosen : bool
        Whether it might have done no more than choose the format: some drivers, as uvcvideo, keep
        that for the program until it closes the device.

    """
    has = ', or has chosen its format and keeps it open' if chosen else ''
    return (f'{device}: the device is busy: another program streams from it{has}; end that '
            f"program ('fuser -v {device}' names it)")


def unplugged(device: str) -> str:
    """Return the sentence for a device that is gone."""
    return f'{device}: the device is gone (unplugged?); connect it and open it again'


def no_writer(device: str, takes_one: bool = True) -> str:
    """
    Return the sentence for a loopback device without pictures.

    Parameters
    ----------
    device : str
        Its path.
    takes_one : bool
        Whether it can be written to. With exclusive_caps a device of version 0.12 is an output
        until a program calls write(), and neither that nor a camera once it has ended.

    """
    if not takes_one:
        return (f'{device}: the program that wrote into this v4l2loopback device has ended, and '
                'version 0.12 lets no other one write after it (exclusive_caps=1); load the '
                "module again ('sudo modprobe -r v4l2loopback', then modprobe with your options), "
                'with exclusive_caps=0 or in a newer version, which do not do that')
    return (f'{device}: no program writes pictures into this v4l2loopback device yet; start the '
            'one that does, such as ffmpeg -f v4l2 or GStreamer with v4l2sink')
