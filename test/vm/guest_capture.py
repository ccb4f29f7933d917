"""
Runs in the guest: let V4l2Camera meet the driver, and write down what came of it.

The folder holds scene.grey and scene.yuyv, and gets capture.json.
"""

from __future__ import annotations

import fcntl
import grp
import hashlib
import json
import os
from pathlib import Path
import struct
import time
from typing import Any

from blob_tracker.capture import CaptureError, V4l2Camera
import numpy as np
from vm.hdmi_loop import (
    CAPTURE, close_loop, control, HEIGHT, NEXT_FRAME, OUTPUT, playing, SLOWNESS, v4l2_ctl, WIDTH,
)

COUNT = 40  # frames of each recording: beyond the end of the scene
SETTINGS: dict[str, Any] = {'device': CAPTURE, 'width': WIDTH, 'height': HEIGHT}
S_CTRL = 0xc008561c
INJECT_BUFFER_ERROR = 0x00f0f042  # vivid's control
NOBODY = 65534


def digest(image: np.ndarray) -> str:
    """Return what two pictures share only if they are equal bit by bit."""
    return hashlib.blake2b(np.ascontiguousarray(image).data, digest_size=8).hexdigest()


def refusal(**settings: Any) -> str:
    """Return the sentence with which a camera is refused, '' if it is not."""
    try:
        V4l2Camera(**{**SETTINGS, **settings}).close()
    except CaptureError as error:
        return str(error)
    return ''


def complaint(camera: V4l2Camera, timeout: float = NEXT_FRAME) -> str:
    """Return the sentence with which reading ends; '' if 20 frames come without one."""
    try:
        for _ in range(20):
            camera.read(timeout)
    except CaptureError as error:
        return str(error)
    return ''


def recording(folder: Path, pixel_format: str, known: dict[str, int]) -> dict[str, Any]:
    """Read the playing scene; a frame's index is its place in the scene, -1 if not from it."""
    frames: list[dict[str, int]] = []
    with playing(folder / f'scene.{pixel_format.lower()}', pixel_format), V4l2Camera(
            **SETTINGS, pixel_format=pixel_format) as camera:
        deadline = time.monotonic() + 30.0 * SLOWNESS
        while len(frames) < COUNT and time.monotonic() < deadline:
            frame = camera.read(NEXT_FRAME)
            read_ns = time.time_ns()
            index = known.get(digest(frame.image), -1)
            if index < 0 and not frames:
                continue  # the driver's own picture, until the player has begun
            frames.append({
                'index': index, 'stamp_ns': frame.stamp_ns, 'read_ns': read_ns,
                'sequence': camera.sequence, 'drops': camera.drops})
        return {
            'count': COUNT, 'size': [camera.width, camera.height], 'frame_rate': camera.frame_rate,
            'pixel_format': camera.pixel_format,
            'shape': frame.image.shape, 'dtype': str(frame.image.dtype),
            'saturation': frame.saturation, 'frames': frames}


def losses() -> dict[str, Any]:
    """Let the driver lose and spoil frames, and the reader stall."""
    found: dict[str, Any] = {}
    with V4l2Camera(**SETTINGS) as camera:
        camera.read(NEXT_FRAME)
        first = camera.sequence
        found['read_after_first'] = 71
        control(percentage_of_dropped_buffers=50)
        for _ in range(10):  # while the control was set, frames were lost to the full ring
            camera.read(NEXT_FRAME)
        before = camera.drops
        for _ in range(20):
            camera.read(NEXT_FRAME)
        found['half_lost'] = camera.drops - before
        control(percentage_of_dropped_buffers=0)
        for _ in range(20):
            camera.read(NEXT_FRAME)
        before = camera.drops
        for _ in range(20):
            fcntl.ioctl(camera._fd, S_CTRL, struct.pack('Ii', INJECT_BUFFER_ERROR, 1))
            camera.read(NEXT_FRAME)
        found['spoilt'] = camera.drops - before
        time.sleep(1.5)
        woken_ns = time.time_ns()
        found['older_than_wake_s'] = (woken_ns - camera.read(NEXT_FRAME).stamp_ns) / 1e9
        found['numbers'] = camera.sequence - first
        found['lost'] = camera.drops
        control(percentage_of_dropped_buffers=100)
        found['quiet'] = complaint(camera, timeout=0.5)
        control(percentage_of_dropped_buffers=0)
        found['after_quiet'] = complaint(camera)
    return found


def sentences() -> dict[str, str]:
    """Return what is said where something stands in the way."""
    found = {
        'missing': refusal(device='/dev/video7'),
        'output': refusal(device=OUTPUT),
        'media': refusal(device='/dev/media0'),
        'format_unknown': refusal(pixel_format='GREI'),
        'format_not_offered': refusal(pixel_format='MJPG'),
        'size': refusal(width=20000),
    }
    link = Path('/run/usb-camera-index0')
    link.symlink_to(CAPTURE)
    found['link'] = refusal(device=str(link))
    with V4l2Camera(**SETTINGS):
        found['busy'] = refusal()
    found['free_again'] = refusal()

    # As udev leaves it on every desktop.
    os.chown(CAPTURE, 0, grp.getgrnam('video').gr_gid)
    os.chmod(CAPTURE, 0o660)
    groups = os.getgroups()
    os.setgroups([])
    os.setegid(NOBODY)
    os.seteuid(NOBODY)
    found['permission'] = refusal()
    os.seteuid(0)
    os.setegid(0)
    os.setgroups(groups)

    control(dv_timings_signal_mode=1)
    found['no_signal'] = refusal()
    control(dv_timings_signal_mode=2)
    found['no_lock'] = refusal()
    control(dv_timings_signal_mode=0)
    with V4l2Camera(**SETTINGS) as camera:
        control(dv_timings_signal_mode=1, percentage_of_dropped_buffers=100)
        found['signal_lost'] = complaint(camera, timeout=0.5)
        control(dv_timings_signal_mode=0, percentage_of_dropped_buffers=0)
    with V4l2Camera(**SETTINGS) as camera:
        v4l2_ctl(CAPTURE, '-c', 'inject_fatal_streaming_error=1')
        found['fatal'] = complaint(camera)
    with V4l2Camera(**SETTINGS) as camera:
        v4l2_ctl(CAPTURE, '-c', 'disconnect=1')
        found['unplugged'] = complaint(camera)
    found['plugged_again'] = refusal()
    return found


def main(folder: Path) -> None:
    """Do all of it."""
    close_loop()
    scene = np.fromfile(folder / 'scene.grey', np.uint8).reshape(-1, HEIGHT, WIDTH)
    known = {digest(frame): index for index, frame in enumerate(scene)}
    found = {name: recording(folder, name, known) for name in ('GREY', 'YUYV')}
    found['losses'] = losses()
    found['sentences'] = sentences()
    (folder / 'capture.json').write_text(json.dumps(found, indent=1))
