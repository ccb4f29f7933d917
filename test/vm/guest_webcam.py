"""
Runs in the guest: V4l2Camera on the kernel's `uvcvideo`, whose webcam is played by `webcam.py`.

The folder gets webcam.json.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
import json
from pathlib import Path
import signal
import time
from typing import Any

from blob_tracker.capture import CaptureError, V4l2Camera
import numpy as np
from vm import webcam
from vm.fork import Fork
from vm.hdmi_loop import NEXT_FRAME, SLOWNESS
from vm.webcam import Faults, Webcam

NODES = Path('/sys/class/video4linux')
OPTIONS = Path('/sys/module/uvcvideo/parameters')
APPEARS = 20.0 * SLOWNESS  # s; two on a quiet machine
COUNT = 26  # frames
QUERIES = range(webcam.GET_CUR, webcam.GET_DEF + 1)


def every(unit: int, selector: int) -> frozenset[tuple[int, int, int]]:
    """Return all requests that read a control."""
    return frozenset((unit, selector, request) for request in QUERIES)


SCENARIOS: dict[str, Faults] = {
    'sound': Faults(),
    'bulk': Faults(bulk=True),
    'lost': Faults(lost=frozenset({9, 14, 15, 20})),
    'endless': Faults(endless=True),
    'chatter': Faults(chatter=True),
    'stalled minimum': Faults(
        bulk=True, stalls=frozenset({(*webcam.CONTRAST, webcam.GET_MIN)})),
    'stalled value': Faults(
        bulk=True, stalls=frozenset({(*webcam.EXPOSURE, webcam.GET_CUR)})),
    'silent': Faults(bulk=True, silent=every(*webcam.CONTRAST)),
    'without its time': Faults(),
    'with its time': Faults(clock=True),
    'no mode': Faults(bulk=True, stalls=frozenset({(*webcam.AUTO, webcam.GET_DEF)})),
}
HARDWARE_STAMPS = 'without its time', 'with its time'
STREAMING = 'sound', 'bulk', 'lost', 'endless', 'chatter'


@contextmanager
def plugged(faults: Faults) -> Iterator[tuple[str, Callable[[], None]]]:
    """Plug a webcam in, give its device and what unplugs it, and unplug it."""
    def play() -> None:
        player = Webcam(faults)
        player.plug()
        player.run()

    before = set(NODES.iterdir())
    process = Fork(play, Path('/run/webcam.log')).begin()
    try:
        wait(lambda: len(set(NODES.iterdir()) - before) >= 2)  # the video and its metadata
        device = min(set(NODES.iterdir()) - before, key=lambda node: int(node.name[5:]))
        path = Path('/dev', device.name)
        wait(path.exists)
        yield str(path), partial(process.send_signal, signal.SIGKILL)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
        wait(lambda: set(NODES.iterdir()) <= before)


def wait(done: Callable[[], bool], longest: float = APPEARS) -> None:
    """Wait until something is so."""
    end = time.monotonic() + longest
    while not done():
        if time.monotonic() > end:
            raise TimeoutError(Path('/run/webcam.log').read_text())
        time.sleep(0.05)


def listed(camera: V4l2Camera) -> dict[str, Any]:
    """Return the values of the controls that there are; None of those that cannot be read."""
    values: dict[str, Any] = {}
    for name, control in camera.controls.items():
        try:
            values[name] = camera.get_control(control)
        except CaptureError as error:
            values[name] = str(error)
    return values


def streamed(camera: V4l2Camera) -> dict[str, Any]:
    """Read frames; a frame's number is its grey."""
    frames: list[dict[str, int]] = []
    while len(frames) < COUNT and (not frames or frames[-1]['number'] < COUNT):
        frame = camera.read(NEXT_FRAME)
        grey = np.unique(frame.image)
        frames.append({
            'number': int(grey[0]) - 16, 'greys': len(grey), 'stamp_ns': frame.stamp_ns,
            'read_ns': time.time_ns(), 'drops': camera.drops, 'sequence': camera.sequence})
    return {'frames': frames, 'place': camera.stamp_place, 'longest_wait': camera.longest_wait,
            'frame_rate': camera.frame_rate}


def scenario(name: str, device: str) -> dict[str, Any]:
    """Return what the camera makes of a webcam."""
    began = time.monotonic()
    with V4l2Camera(device, webcam.WIDTH, webcam.HEIGHT, 'YUYV') as camera:
        found: dict[str, Any] = {'opening_s': time.monotonic() - began}
        began = time.monotonic()
        found['controls'] = listed(camera)
        found['listing_s'] = time.monotonic() - began
        found['exposure_time'] = camera.exposure_time
        if name in STREAMING:
            found |= streamed(camera)
    return found


def in_real_time(device: str) -> list[float]:
    """Return how old frames are, s, whose stamps the driver takes from the real-time clock."""
    option = OPTIONS / 'clock'
    before = option.read_text()
    option.write_text('CLOCK_REALTIME')
    try:
        with V4l2Camera(device, webcam.WIDTH, webcam.HEIGHT, 'YUYV') as camera:
            return [
                -camera.read(NEXT_FRAME).stamp_ns / 1e9 + time.time() for _ in range(5)]
    finally:
        option.write_text(before)


def by_its_own_clock(device: str) -> list[str]:
    """Return what the stamps are said to be, before the first frame and after some."""
    option = OPTIONS / 'hwtimestamps'
    before = option.read_text()
    option.write_text('1')
    try:
        with V4l2Camera(device, webcam.WIDTH, webcam.HEIGHT, 'YUYV') as camera:
            places = [camera.stamp_place]
            for _ in range(5):
                camera.read(NEXT_FRAME)
            return [*places, camera.stamp_place]
    finally:
        option.write_text(before)


def unplugged(device: str, unplug: Callable[[], None]) -> str:
    """Return what is said of a webcam that is unplugged while it streams."""
    with V4l2Camera(device, webcam.WIDTH, webcam.HEIGHT, 'YUYV') as camera:
        camera.read(NEXT_FRAME)
        unplug()
        try:
            for _ in range(50):
                camera.read(NEXT_FRAME)
        except CaptureError as error:
            return str(error)
    return ''


def main(folder: Path) -> None:
    """Do all of it."""
    found: dict[str, Any] = {}
    for name, faults in SCENARIOS.items():
        began = time.monotonic()
        with plugged(faults) as (device, unplug):
            found[name] = {'plugged_s': time.monotonic() - began, 'device': device}
            try:
                if name in HARDWARE_STAMPS:
                    found[name]['places'] = by_its_own_clock(device)
                    continue
                found[name] |= scenario(name, device)
            except CaptureError as error:
                found[name]['error'] = str(error)
            if name == 'sound':
                found['in real time'] = in_real_time(device)
            if name == 'bulk':
                found['unplugged'] = unplugged(device, unplug)
        print(f'webcam, {name}: {time.monotonic() - began:.1f} s', flush=True)
    (folder / 'webcam.json').write_text(json.dumps(found, indent=1))
