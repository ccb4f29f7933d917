"""The cameras: what they are, what they offer, and who has them."""

from __future__ import annotations

from collections.abc import Iterator
import errno
from functools import partial
import os
from pathlib import Path

from blob_tracker.commands.doctor.finding import error, Finding, Level, ok, warn

DEVICES = Path('/dev')
PROCESSES = Path('/proc')
SECONDS = 1.0  # of streaming
PATIENCE = 3.0  # s for a frame


def check_cameras(devices: Path = DEVICES, processes: Path = PROCESSES) -> Iterator[Finding]:
    """
    Look at every video device.

    Parameters
    ----------
    devices : Path
        Folder of video0 and v4l/by-id.
    processes : Path
        /proc, where the kernel tells who has opened what.

    """
    from blob_tracker.capture.device import device_paths

    paths = device_paths(devices)
    if not paths:
        yield warn(
            'camera',
            f'there is no {devices}/video*: no camera is plugged in, or its driver is not loaded, '
            'or a container keeps it away (--device=/dev/video0); the simulator needs none',
            'see what the kernel says of it',
            "sudo dmesg | grep -iE 'video|uvc'",
        )
    for path in paths:
        yield from check_camera(path, devices, processes)


def check_camera(
    path: str, devices: Path = DEVICES, processes: Path = PROCESSES
) -> Iterator[Finding]:
    """Look at one video device without streaming from it."""
    from blob_tracker.capture import CaptureError, PIXEL_FORMATS, videodev2
    from blob_tracker.capture.device import (
        buffer_type, bus, capabilities, CAPTURES, driver, kind, not_v4l2, open_device,
    )
    from blob_tracker.capture.format import offered_formats, offered_sizes
    from blob_tracker.capture.pixel_formats.undecoded import advice
    from blob_tracker.capture.refusals import LOOPBACK, no_writer
    from blob_tracker.capture.sensor import of_video_device

    try:
        fd = open_device(path)
    except CaptureError as fault:
        yield error('camera', str(fault))
        return
    try:
        flags, card = capabilities(fd)
        who = f'{path}: {card} ({driver(fd)}, {bus(fd)})'
        if driver(fd) == LOOPBACK and not flags & CAPTURES:
            yield warn('camera', no_writer(path, bool(flags & videodev2.CAP_VIDEO_OUTPUT)))
            return
        if not flags & CAPTURES or not flags & videodev2.CAP_STREAMING:
            yield ok('camera', f'{who}: {kind(flags)}, no pictures come from it')
            return
        link = by_id(path, devices)
        who += f', {link}' if link else ''
        behind = of_video_device(fd)
        who += f', sensor {behind[0].name} ({", ".join(behind[1])})' if behind else ''
        call = partial(videodev2.ioctl, fd)
        formats = offered_formats(call, buffer_type(fd))
        usable = {name: offered_sizes(call, name) for name in formats if name in PIXEL_FORMATS}
    except OSError as fault:
        fails = fault.errno not in (errno.ENOTTY, errno.EINVAL)
        yield error(
            'camera', f'{path}: it fails: {fault.strerror}' if fails else not_v4l2(path),
            'see which there are', 'v4l2-ctl --list-devices',
        )
        return
    finally:
        os.close(fd)
    if not usable:
        yield error(
            'camera',
            f'{who}: none of its pixel formats ({", ".join(formats) or "it lists none"}) can be '
            f'read; one of {", ".join(PIXEL_FORMATS)} is needed{advice(formats)}',
            'see whether it has another mode or input',
            f'v4l2-ctl -d {path} --list-formats-ext',
        )
        return
    offers = '; '.join(f'{name} {sizes}'.strip() for name, sizes in usable.items())
    holders = opened_by(path, processes)
    if holders:
        yield warn(
            'camera',
            f'{who}: {offers}; it is open in {", ".join(holders)}, and just one program can '
            'stream from it',
            'end that program, unless it is the tracker itself',
            f'fuser -v {path}',
        )
        return
    yield ok('camera', f'{who}: {offers}')


def by_id(path: str, devices: Path = DEVICES) -> str:
    """Return the link that stays the camera's when others are plugged in, '' without one."""
    place = Path(path).resolve()
    for link in sorted(devices.glob('v4l/by-id/*')):
        if link.resolve() == place:
            return str(link)
    return ''


def opened_by(path: str, processes: Path = PROCESSES) -> list[str]:
    """Return the other processes that have a file open, as far as they may be looked into."""
    place = str(Path(path).resolve())
    found = []
    for process in sorted(processes.glob('[0-9]*'), key=lambda process: int(process.name)):
        if int(process.name) == os.getpid():
            continue
        try:
            if any(os.readlink(link) == place for link in (process / 'fd').iterdir()):
                found.append(f'{(process / "comm").read_text().strip()} ({process.name})')
        except OSError:
            continue  # another user's, or it has ended meanwhile
    return found


def check_stream(path: str) -> Iterator[Finding]:
    """Look at one camera, and read frames from it with the settings that its driver has."""
    from blob_tracker.capture import CaptureError, V4l2Camera

    for finding in check_camera(path):
        yield finding
        if finding.level is Level.ERROR:
            return
    count = 0
    try:
        with V4l2Camera(path) as camera:
            first = last = camera.read(PATIENCE)
            while last.stamp_ns - first.stamp_ns < 1e9 * SECONDS:
                last = camera.read(PATIENCE)
                count += 1
    except CaptureError as fault:
        yield error('camera', str(fault))
        return
    rate = 1e9 * count / (last.stamp_ns - first.stamp_ns)
    interlaced = f', fields {camera.fields}' if camera.fields.interlaced else ''
    words = (
        f'{path}: {camera.width}x{camera.height} {camera.pixel_format}{interlaced} at {rate:.1f} '
        'frames/s, '
        f'{camera.drops} lost, the brightest pixel {last.image.max()} of {camera.saturation} DN'
    )
    if camera.drops:
        yield warn(
            'camera', words,
            'frames are lost on their way here: another USB port or cable, a smaller size or a '
            'lower rate',
        )
        return
    yield ok('camera', words)
