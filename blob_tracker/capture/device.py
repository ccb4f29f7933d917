"""Finding and opening a V4L2 capture device, with a sentence for all that can stand in the way."""

from __future__ import annotations

import errno
import glob
import grp
import os
from pathlib import Path
import pwd
import stat

from blob_tracker.capture import videodev2
from blob_tracker.capture.errors import CaptureError
from blob_tracker.capture.refusals import busy, LOOPBACK, no_writer
from blob_tracker.capture.sensor import of_subdevice

CAPTURES = videodev2.CAP_VIDEO_CAPTURE | videodev2.CAP_VIDEO_CAPTURE_MPLANE


def open_capture_device(path: str) -> int:
    """
    Open a device that captures video by streaming.

    Parameters
    ----------
    path : str
        /dev/videoN or a link to it, such as those in /dev/v4l/by-id.

    Returns
    -------
    int
        Non-blocking file descriptor.

    Raises
    ------
    CaptureError
        There is no such device, it may not be opened, or it is no such device.

    """
    fd = open_device(path)
    try:
        _check_captures(path, fd)
    except BaseException:
        os.close(fd)
        raise
    return fd


def open_device(path: str) -> int:
    """
    Open a device of any kind.

    Raises
    ------
    CaptureError
        There is no such device, or it may not be opened.

    """
    try:
        return os.open(path, os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
    except OSError as error:
        raise CaptureError(_why_not_open(path, error)) from error


def capabilities(fd: int) -> tuple[int, str]:
    """
    Return the capability flags of an open device node and the name of its card.

    Raises
    ------
    OSError
        ENOTTY where it is not a V4L2 device.

    """
    capability = videodev2.Capability()
    videodev2.ioctl(fd, videodev2.QUERYCAP, capability)
    flags = capability.capabilities
    if flags & videodev2.CAP_DEVICE_CAPS:  # of this node, not of the whole device
        flags = capability.device_caps
    return flags, capability.card.decode(errors='replace')


def driver(fd: int) -> str:
    """Return the name of the driver of an open device node."""
    capability = videodev2.Capability()
    videodev2.ioctl(fd, videodev2.QUERYCAP, capability)
    return capability.driver.decode(errors='replace')


def bus(fd: int) -> str:
    """Return where an open device node sits: usb-0000:00:14.0-1, say."""
    capability = videodev2.Capability()
    videodev2.ioctl(fd, videodev2.QUERYCAP, capability)
    return capability.bus_info.decode(errors='replace')


def buffer_type(fd: int) -> int:
    """Return the type of buffers that an open capture device fills: single- or multi-planar."""
    flags, _ = capabilities(fd)
    if flags & videodev2.CAP_VIDEO_CAPTURE:
        return videodev2.BUF_TYPE_VIDEO_CAPTURE
    return videodev2.BUF_TYPE_VIDEO_CAPTURE_MPLANE


def device_paths(folder: Path = Path('/dev')) -> list[str]:
    """Return the video devices of this machine, of any kind, in the order of their numbers."""
    numbers = {path: path.rpartition('video')[2] for path in glob.glob(f'{folder}/video*')}
    paths = [path for path, number in numbers.items() if number.isdecimal()]
    return sorted(paths, key=lambda path: int(numbers[path]))


def capture_devices() -> dict[str, str]:
    """Return the capture devices of this machine that can be opened: path -> name."""
    found = {}
    for path in device_paths():
        try:
            fd = os.open(path, os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
        except OSError:
            continue
        try:
            flags, card = capabilities(fd)
            if flags & CAPTURES and flags & videodev2.CAP_STREAMING:
                found[path] = card
        except OSError:
            pass
        finally:
            os.close(fd)
    return found


def _there_are() -> str:
    devices = capture_devices()
    if not devices:
        return 'this machine has no capture device that can be opened'
    return 'capture devices here: ' + ', '.join(
        f'{path} ({card})' for path, card in devices.items())


def _why_not_open(path: str, error: OSError) -> str:
    if error.errno == errno.ENOENT:
        return f'{path}: there is no such device; {_there_are()}'
    if error.errno in (errno.ENXIO, errno.ENODEV):
        return f'{path}: there is no device behind this node any more; {_there_are()}'
    if error.errno == errno.EBUSY:
        return busy(path)
    if error.errno == errno.EACCES:
        return _no_permission(path)
    if error.errno == errno.EPERM:  # whoever one is, and whatever the mode: a device cgroup
        return (f'{path}: the system keeps this device from the program, as for a container: '
                f'start the container with --device={path}')
    if error.errno == errno.EISDIR:
        return not_v4l2(path)
    return f'{path}: cannot be opened: {error.strerror}; {_there_are()}'


def _no_permission(path: str) -> str:
    try:
        status = os.stat(path)
    except OSError:
        return f'{path}: permission denied on the way to it; make its folders accessible'
    group = _group_name(status.st_gid)
    wrong = (f'{path}: permission denied: it belongs to {_user_name(status.st_uid)}:{group} '
             f'with mode {stat.S_IMODE(status.st_mode):04o}')
    if status.st_mode & stat.S_IRGRP and status.st_mode & stat.S_IWGRP and status.st_gid != 0:
        user = _user_name(os.geteuid())
        return f"{wrong}; run 'sudo usermod -aG {group} {user}' and log in again"
    return f'{wrong}; its group needs to be one you are in, with read and write permission'


def _user_name(uid: int) -> str:
    try:
        return pwd.getpwuid(uid).pw_name
    except KeyError:
        return str(uid)


def _group_name(gid: int) -> str:
    try:
        return grp.getgrgid(gid).gr_name
    except KeyError:
        return str(gid)


def not_v4l2(path: str) -> str:
    """Return the sentence for a path that is no video device; of a subdevice what it feeds."""
    subdevice = of_subdevice(path)
    if subdevice is None:
        return f'{path}: this is not a V4L2 device; {_there_are()}'
    name, videos = subdevice
    if videos is None:
        come = ('no pictures come from it, as from a lens or a flash: name the video device of '
                'its camera')
    elif videos:
        come = (f'its pictures come from {" or ".join(videos)}: name that, its controls are found '
                'by themselves')
    else:
        come = ("its link to a video device is not enabled: see 'media-ctl -p', and media-ctl "
                '--links')
    return f'{path}: this is a subdevice, {name}; {come}'


_KINDS = (
    (videodev2.CAP_VIDEO_M2M | videodev2.CAP_VIDEO_M2M_MPLANE, 'a memory-to-memory device'),
    (videodev2.CAP_VIDEO_OUTPUT | videodev2.CAP_VIDEO_OUTPUT_MPLANE, 'an output device'),
    (videodev2.CAP_META_CAPTURE, 'a metadata device'),
)


def kind(flags: int) -> str:
    """Return in words what a device with these capabilities is, that does not capture."""
    return next((name for flag, name in _KINDS if flags & flag), 'another kind of device')


def _check_captures(path: str, fd: int) -> None:
    try:
        flags, _ = capabilities(fd)
    except OSError as error:
        if error.errno in (errno.ENOTTY, errno.EINVAL):
            raise CaptureError(not_v4l2(path)) from error
        raise CaptureError(f'{path}: cannot be queried: {error.strerror}') from error
    if not flags & CAPTURES:
        if driver(fd) == LOOPBACK:  # exclusive_caps: an output until somebody writes
            takes_one = bool(flags & videodev2.CAP_VIDEO_OUTPUT)
            raise CaptureError(no_writer(path, takes_one))
        raise CaptureError(
            f'{path}: this is {kind(flags)}, not a capture device; {_there_are()}')
    if not flags & videodev2.CAP_STREAMING:
        raise CaptureError(
            f'{path}: this device has no streaming I/O, which frames are read by; {_there_are()}')
