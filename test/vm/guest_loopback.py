"""
Runs in the guest: V4l2Camera on v4l2loopback, of which a program here is the writer.

The folder gets loopback.json.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import json
import os
from pathlib import Path
import subprocess
import threading
import time
from typing import Any

from blob_tracker.capture import CaptureError, V4l2Camera, videodev2
import numpy as np
from vm.hdmi_loop import NEXT_FRAME, SLOWNESS
from vm.output_queue import BUF_TYPE_VIDEO_OUTPUT, OutputQueue

# One that is an output until somebody writes, and one that is always both.
EXCLUSIVE, OPEN = '/dev/video20', '/dev/video21'
OPTIONS = 'devices=2', 'video_nr=20,21', 'exclusive_caps=1,0'
SIZE, OTHER_SIZE = (160, 120), (80, 60)  # px
RATE = 20.0  # pictures/s that are written
ASKED_RATE = 60.0  # frames/s
SILENCE = 0.5 * SLOWNESS  # s, ten pictures
COUNT = 24  # frames: enough to tell their rate
SINCE_THE_START_NS = 7_000_000_000


@contextmanager
def loaded(module: Path) -> Iterator[None]:
    """Load the driver, and unload it."""
    subprocess.run(['insmod', str(module), *OPTIONS], check=True)
    try:
        yield
    finally:
        subprocess.run(['rmmod', 'v4l2loopback'], check=True)


def output(device: str, size: tuple[int, int]) -> int:
    """Return the descriptor of a device that is told what will be written."""
    fd = os.open(device, os.O_RDWR)
    told = videodev2.Format(type=BUF_TYPE_VIDEO_OUTPUT)
    told.pix.width, told.pix.height = size
    told.pix.pixelformat = videodev2.fourcc('GREY')
    told.pix.field = videodev2.FIELDS.index('none')
    try:
        videodev2.ioctl(fd, videodev2.S_FMT, told)
        if (told.pix.width, told.pix.height) != size:
            raise OSError(f'it is given {told.pix.width}x{told.pix.height}')
    except OSError:
        os.close(fd)
        raise
    return fd


def picture(number: int, size: tuple[int, int]) -> bytes:
    """Return a picture of one grey that tells the number."""
    return bytes([number % 256]) * (size[0] * size[1])


@contextmanager
def repeated(action: Callable[[int], None]) -> Iterator[None]:
    """Do something at RATE, with the number of the time."""
    ended = threading.Event()

    def run() -> None:
        number = 0
        while not ended.wait(1.0 / RATE):
            action(number)
            number += 1

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


@contextmanager
def writing(device: str, size: tuple[int, int] = SIZE) -> Iterator[list[int]]:
    """Write pictures, as ffmpeg does; give when each was begun, monotonic ns."""
    fd = output(device, size)
    begun: list[int] = []

    def show(number: int) -> None:
        begun.append(time.monotonic_ns())
        os.write(fd, picture(number, size))

    try:
        with repeated(show):
            yield begun
    finally:
        os.close(fd)


@contextmanager
def queueing(device: str, stamp_ns: Callable[[int], int]) -> Iterator[None]:
    """Hand pictures over in mapped buffers with stamps, as v4l2-ctl and GStreamer do."""
    fd = output(device, SIZE)
    queue = OutputQueue(fd)

    def show(number: int) -> None:
        index = number if number < len(queue) else queue.take().index
        queue.put(index, picture(number, SIZE), stamp_ns(number))
        if number == 0:
            queue.start()

    try:
        with repeated(show):
            yield
    finally:
        queue.close()
        os.close(fd)


def opened(device: str) -> V4l2Camera:
    """Return the camera once there is a picture."""
    end = time.monotonic() + NEXT_FRAME
    while True:
        try:
            return V4l2Camera(device, frame_rate=ASKED_RATE)
        except CaptureError:
            if time.monotonic() > end:
                raise
            time.sleep(0.05)


def refusal(device: str) -> str:
    """Return the sentence with which a device is refused, '' if it is not."""
    try:
        V4l2Camera(device).close()
    except CaptureError as error:
        return str(error)
    return ''


def read(camera: V4l2Camera, count: int) -> list[dict[str, int]]:
    """Read frames; a frame's number is its grey."""
    frames = []
    for _ in range(count):
        frame = camera.read(NEXT_FRAME)
        grey = np.unique(frame.image)
        frames.append({
            'number': int(grey[0]), 'greys': len(grey), 'stamp_ns': frame.stamp_ns,
            'read_ns': time.time_ns(), 'drops': camera.drops})
    return frames


@contextmanager
def clocks_noted(camera: V4l2Camera, clocks: list[int]) -> Iterator[None]:
    """Note what the driver says of each stamp's clock."""
    take = camera._ring.take

    def noted() -> Any:
        buffer = take()
        if buffer is not None:
            clocks.append(buffer.flags & videodev2.BUF_FLAG_TIMESTAMP_MASK)
        return buffer

    camera._ring.take = noted  # type: ignore[method-assign]
    yield
    camera._ring.take = take  # type: ignore[method-assign]


def written(device: str) -> dict[str, Any]:
    """Read what is written, by one program and then by others."""
    found: dict[str, Any] = {'no writer': refusal(device), 'clocks': []}
    with writing(device) as found['begun_ns']:
        camera = opened(device)
        with clocks_noted(camera, found['clocks']):
            found['frames'] = read(camera, COUNT)
    with camera:
        found |= {'frame_rate': camera.frame_rate, 'measured_rate': camera.measured_rate,
                  'stamps_ns': [stamp_ns for _, stamp_ns in camera._count._measured._last],
                  'patience': SILENCE}
        try:
            while True:  # what it had written before
                camera.read(SILENCE)
        except CaptureError as error:
            found['gone'] = f'{type(error).__name__}: {error}'
        with writing(device):
            found['taken over'] = read(camera, 5)
        try:
            with writing(device, OTHER_SIZE):
                found['other size meanwhile'] = ''
        except OSError as error:
            found['other size meanwhile'] = str(error)
    found['gone for long'] = refusal(device)
    try:
        with writing(device, OTHER_SIZE), opened(device) as camera:
            found['other size'] = [camera.width, camera.height]
            found['frames of it'] = read(camera, 5)
    except OSError as error:  # of the writer
        found['writer'] = error.strerror
    return found


def queued(device: str) -> dict[str, Any]:
    """Read pictures whose stamps the writer leaves out, or makes."""
    stamps: dict[str, Callable[[int], int]] = {
        'left out': lambda number: 0,
        'monotonic': lambda number: time.monotonic_ns(),
        'since the start': lambda number: round((1 + number) * 1e9 / RATE),
    }
    found: dict[str, Any] = {}
    for name, stamp_ns in stamps.items():
        with queueing(device, stamp_ns), opened(device) as camera:
            try:
                found[name] = read(camera, 5)
            except CaptureError as error:
                found[name] = str(error)
    return found


def main(folder: Path) -> None:
    """Do all of it."""
    found: dict[str, Any] = {}
    for module in sorted(Path(os.environ['DRIVERS']).glob('v4l2loopback-*.ko')):
        began = time.monotonic()
        with loaded(module):
            found[module.stem] = {
                'exclusive': written(EXCLUSIVE), 'open': written(OPEN), 'queued': queued(OPEN)}
        print(f'{module.stem}: {time.monotonic() - began:.1f} s', flush=True)
    (folder / 'loopback.json').write_text(json.dumps(found, indent=1))
