"""
Runs in the guest: play random pixels in many formats, and compare what V4l2Camera makes of them.

The folder gets formats.json. What is right is worked out here, sample by sample from the kernel's
description of each format, without the package's decoders.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import json
from pathlib import Path
import time
from typing import Any

from blob_tracker.capture import CaptureError, V4l2Camera, videodev2
from blob_tracker.types import Frame
import numpy as np
from numpy.typing import NDArray
from vm.hdmi_loop import (
    CAPTURE, close_loop, control, NEXT_FRAME, OUTPUT, playing, SIGNAL, SLOWNESS, v4l2_ctl,
)

PLANAR = CAPTURE, OUTPUT  # single-planar buffers
MULTI_PLANAR = '/dev/video2', '/dev/video3'
RAW = Path('/dev/shm/formats.raw')
RANDOM = np.random.default_rng(7)
FRAMES = 2  # right ones in a row
# s until them: the driver's own picture comes first, and the player takes a while
LONGEST = 20.0 * SLOWNESS
Picture = NDArray[np.generic]


def grey(width: int, height: int) -> tuple[Picture, Picture]:
    """Return the bytes of a GREY picture and its luma."""
    raw = RANDOM.integers(0, 256, (height, width), np.uint8)
    return raw, raw


def words(bits: int, order: str = '<') -> Callable[[int, int], tuple[Picture, Picture]]:
    """Return the maker of words that hold samples of so many bits."""
    def make(width: int, height: int) -> tuple[Picture, Picture]:
        samples = RANDOM.integers(0, 1 << bits, (height, width), np.uint16)
        return samples.astype(f'{order}u2'), samples
    return make


def yuv422(place: int) -> Callable[[int, int], tuple[Picture, Picture]]:
    """Return the maker of packed YUV with the luma at a byte of each pair."""
    def make(width: int, height: int) -> tuple[Picture, Picture]:
        raw = RANDOM.integers(0, 256, (height, width, 2), np.uint8)
        return raw, raw[..., place]
    return make


def yuv420(width: int, height: int) -> tuple[Picture, Picture]:
    """Return planar YUV: all of the luma, then half as many bytes of chroma."""
    raw = RANDOM.integers(0, 256, (height * 3 // 2, width), np.uint8)
    return raw, raw[:height]


def rgb(*order: int, size: int) -> Callable[[int, int], tuple[Picture, Picture]]:
    """Return the maker of pixels of `size` bytes with R, G and B at these."""
    def make(width: int, height: int) -> tuple[Picture, Picture]:
        raw = RANDOM.integers(0, 256, (height, width, size), np.uint8)
        red, green, blue = (raw[..., place].astype(int) for place in order)
        luma = 0.299 * red + 0.587 * green + 0.114 * blue
        clipped = (red == 255) | (green == 255) | (blue == 255)
        return raw, np.where(clipped, 255, luma)
    return make


def bayer(first: int, bits: int) -> Callable[[int, int], tuple[Picture, Picture]]:
    """Return the maker of Bayer with the first row's green in column `first`."""
    def make(width: int, height: int) -> tuple[Picture, Picture]:
        full = (1 << bits) - 1
        samples = RANDOM.integers(0, full + 1, (height, width), np.uint16)
        luma = np.empty((height // 2, width // 2), int)
        for y, x in np.ndindex(luma.shape):
            one = int(samples[2 * y, 2 * x + first])
            other = int(samples[2 * y + 1, 2 * x + 1 - first])
            total, most = (one + other, 2 * full) if bits < 16 else ((one + other) // 2, full)
            luma[y, x] = most if max(one, other) == full else total
        return samples.astype(np.uint8 if bits == 8 else '<u2'), luma
    return make


# name -> devices, size, what is played
FORMATS: dict[str, tuple[tuple[str, str], int, int, Any]] = {
    'Y10': (PLANAR, 160, 120, words(10)),
    'Y16': (PLANAR, 640, 480, words(16)),
    'Y16-BE': (PLANAR, 320, 180, words(16, '>')),
    'UYVY': (PLANAR, 324, 242, yuv422(1)),
    'NV12': (PLANAR, 320, 240, yuv420),
    'RGB3': (PLANAR, 160, 120, rgb(0, 1, 2, size=3)),
    'BGR4': (PLANAR, 160, 120, rgb(2, 1, 0, size=4)),
    'RGGB': (PLANAR, 160, 120, bayer(1, 8)),
    'GB10': (PLANAR, 160, 120, bayer(0, 10)),
    'GR16': (PLANAR, 160, 120, bayer(0, 16)),
}
MULTI_PLANAR_FORMATS: dict[str, tuple[tuple[str, str], int, int, Any]] = {
    'Y16': (MULTI_PLANAR, 160, 120, words(16)),
    'NV12': (MULTI_PLANAR, 160, 120, yuv420),
    'NM12': (MULTI_PLANAR, 320, 240, yuv420),
}


def seen(camera: V4l2Camera, expected: Picture) -> dict[str, Any]:
    """Read until the expected picture has come FRAMES times in a row."""
    # Half for the rounding of a computed luma, and the bits of its weights.
    tolerance = 0.52 if expected.dtype == float else 0
    right = 0
    deadline = time.monotonic() + LONGEST
    while right < FRAMES and time.monotonic() < deadline:
        frame = camera.read(NEXT_FRAME)
        same = frame.image.shape == expected.shape and (
            np.abs(frame.image - expected.astype(float)).max() <= tolerance)
        right = right + 1 if same else 0
    return {
        'right': right, 'wanted': FRAMES, 'dtype': str(frame.image.dtype),
        'size': [camera.width, camera.height], 'shape': list(frame.image.shape),
        'expected_shape': list(expected.shape), 'saturation': frame.saturation,
        **place(camera, frame)}


def place(camera: V4l2Camera, frame: Frame) -> dict[str, Any]:
    """Return where on the sensor a frame is."""
    return {'place': [frame.x0, frame.y0], 'binning': list(frame.binning),
            'sensor_size': list(camera.sensor_size)}


def geometry(width: int, height: int, pixel_format: str) -> dict[str, Any]:
    """Return where frames of a size are."""
    with V4l2Camera(CAPTURE, width, height, pixel_format) as camera:
        return place(camera, camera.read(NEXT_FRAME))


def played(
    name: str, devices: tuple[str, str], width: int, height: int, make: Any
) -> dict[str, Any]:
    """Play one random picture in a format again and again; return what the camera sees."""
    raw, luma = make(width, height)
    RAW.write_bytes(raw.tobytes())
    capture, output = devices
    number = f'{videodev2.fourcc(name):#x}'  # v4l2-ctl takes no code of three characters
    with playing(RAW, number, output, width, height), V4l2Camera(
            capture, width, height, name) as camera:
        return seen(camera, luma)


@contextmanager
def padded(padding: int) -> Iterator[None]:
    """Have the driver put bytes between lines: the camera itself leaves that to it."""
    def padding_ioctl(fd: int, number: int, argument: Any) -> None:
        if number == videodev2.S_FMT:
            argument.pix.bytesperline = argument.pix.width + padding
        ioctl(fd, number, argument)
    ioctl = videodev2.ioctl
    videodev2.ioctl = padding_ioctl
    try:
        yield
    finally:
        videodev2.ioctl = ioctl


def crop(left: int, top: int, width: int, height: int) -> None:
    """Set the crop of the capture device."""
    v4l2_ctl(CAPTURE, f'--set-selection=target=crop,left={left},top={top},width={width},'
                      f'height={height}')


def selections() -> dict[str, Any]:
    """Look at parts of a playing picture, by the driver's crop and its scaler."""
    found: dict[str, Any] = {}
    raw, luma = grey(640, 480)
    RAW.write_bytes(raw.tobytes())
    with playing(RAW, 'GREY', OUTPUT, 640, 480):
        # The size before the place: without a scaler the crop is as large as the frame.
        V4l2Camera(CAPTURE, 320, 240, 'GREY').close()
        crop(64, 40, 320, 240)
        with V4l2Camera(CAPTURE, 320, 240, 'GREY') as camera:
            found['crop'] = seen(camera, luma[40:280, 64:384])
        control(enable_capture_scaler=1)
        crop(64, 40, 320, 360)
        with V4l2Camera(CAPTURE, 160, 120, 'GREY') as camera:
            # This scaler takes every third line, and every second pair of pixels.
            found['scaled'] = seen(camera, luma[40:400:3, 64:384].reshape(120, -1, 2)[
                :, ::2].reshape(120, 160))
        try:
            V4l2Camera(CAPTURE, 304, 240, 'GREY').close()
        except CaptureError as error:
            found['not_whole'] = str(error)
        crop(0, 0, *SIGNAL)
        found['whole'] = geometry(400, 240, 'GREY')
        found['halved'] = geometry(640, 360, 'GREY')
        found['halved_bayer'] = geometry(640, 360, 'RGGB')
    control(enable_capture_scaler=0)
    return found


def main(folder: Path) -> None:
    """Do all of it."""
    close_loop()
    close_loop(*MULTI_PLANAR)
    found: dict[str, Any] = {'planar': {}, 'multi_planar': {}}
    for name, case in FORMATS.items():
        found['planar'][name] = played(name, *case)
    for name, case in MULTI_PLANAR_FORMATS.items():
        found['multi_planar'][name] = played(name, *case)
    control(loop_video=0, quantization=1)  # a loop has the levels of its output
    with V4l2Camera(CAPTURE, 160, 120, 'YUYV') as camera:
        found['full_range_saturation'] = camera.read(NEXT_FRAME).saturation
    control(loop_video=1, quantization=0)
    with padded(48):
        found['padded'] = played('GREY', PLANAR, 320, 240, grey)
    found['selections'] = selections()
    (folder / 'formats.json').write_text(json.dumps(found, indent=1))
