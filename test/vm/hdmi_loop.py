"""Runs in the guest: what is played into vivid's HDMI output arrives at its HDMI input."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import shutil
import subprocess
import time

from blob_tracker.capture import videodev2

BT_STD_CEA861, BT_STD_CVT = 1, 4
CAPTURE, OUTPUT = '/dev/video0', '/dev/video1'
WIDTH, HEIGHT = 320, 240
SIGNAL = 1280, 720  # px
# From Linux 6.11 on each input has a menu of what it is connected to.
JOINED_BY_MENU = tuple(int(part) for part in os.uname().release.split('.')[:2]) >= (6, 11)
# CTA-861 format 60, 1280x720p24: the slowest there is, for the sake of the emulated processors.
# Without its scalers the driver sends and takes the top left WIDTH x HEIGHT of it.
TIMINGS = videodev2.BtTimings(
    width=1280, height=720, polarities=3, pixelclock=59_400_000, hfrontporch=1760, hsync=40,
    hbackporch=220, vfrontporch=5, vsync=5, vbackporch=20, standards=BT_STD_CEA861)
FRAME_RATE = 24.0
SLOW_SIGNAL = 2560, 1600  # px


def slow_timings(pixelclock: int) -> videodev2.BtTimings:
    """
    Return CVT timings with reduced blanking, for a tracker or a node on emulated processors.

    The driver works the pixel clock out again each time, in steps of 250 kHz: multiples of
    17 MHz stay.
    """
    return videodev2.BtTimings(
        width=2560, height=1600, polarities=2, pixelclock=pixelclock, hfrontporch=48, hsync=32,
        hbackporch=80, vfrontporch=3, vsync=6, vbackporch=7, standards=BT_STD_CVT, flags=1)


SLOW_TIMINGS = slow_timings(17_000_000)
SLOW_FRAME_RATE = 17e6 / (2720 * 1616)  # 3.9
# Of the host, as `support.slowness` has it: all limits of the guest are stretched by it.
SLOWNESS = float(os.environ.get('SLOWNESS', 1.0))
NEXT_FRAME = 5.0 * SLOWNESS  # s; a twenty-fourth on a quiet machine


def v4l2_ctl(device: str, *options: str) -> None:
    """Run v4l2-ctl on a device."""
    subprocess.run(['v4l2-ctl', '-d', device, *options], check=True, timeout=30 * SLOWNESS,
                   stdout=subprocess.DEVNULL)


def control(device: str = CAPTURE, **settings: int | str) -> None:
    """Set controls of a capture device; `loop_video` joins its input to its output."""
    if JOINED_BY_MENU and 'loop_video' in settings:
        number = int(device.removeprefix('/dev/video')) // 2
        # The pattern, nothing, the outputs.
        settings[f'hdmi_{number:03d}_0_is_connected_to'] = (
            2 + number if settings.pop('loop_video') else 0)
    v4l2_ctl(device, '-c', ','.join(f'{name}={value}' for name, value in settings.items()))


def wait_for(device: str, longest: float = 40.0 * SLOWNESS) -> None:
    """Wait until a device can be opened: once unplugged, when the last program has let go."""
    end = time.monotonic() + longest
    while True:
        try:
            os.close(os.open(device, os.O_RDWR))
            return
        except OSError:
            if time.monotonic() > end:
                raise
            time.sleep(0.1)


def close_loop(
    capture: str = CAPTURE, output: str = OUTPUT, timings: videodev2.BtTimings = TIMINGS
) -> None:
    """Give both ends the same timings and join them; vivid writes no text into the picture."""
    for device in (output, capture):
        with open(device, 'rb', buffering=0) as file:
            videodev2.ioctl(file.fileno(), videodev2.S_DV_TIMINGS, videodev2.DvTimings(bt=timings))
    v4l2_ctl(output, '-c', 'enable_output_scaler=0')
    # Stamps at the start of the frame: those at its end lie 0.9 frames ahead of the delivery,
    # as vivid has the picture ready when the frame begins.
    control(
        capture, enable_capture_scaler=0, loop_video=1, osd_text_mode=2, timestamp_source=1)


def take_format(
    pixel_format: str, output: str, width: int, height: int, field: str = 'none'
) -> None:
    """Set what an output device is given."""
    # The driver keeps the region of an earlier, smaller picture.
    region = f'left=0,top=0,width={width},height={height}'
    v4l2_ctl(output, f'--set-fmt-video-out=width={width},height={height},'
                     f'pixelformat={pixel_format},field={field}',
             f'--set-selection-output=target=compose,{region}',
             f'--set-selection-output=target=crop,{region}')


@contextmanager
def playing(
    scene: Path, pixel_format: str, output: str = OUTPUT, width: int = WIDTH, height: int = HEIGHT,
    field: str = 'none',
) -> Iterator[None]:
    """
    Play a raw file into the output device, again and again.

    The player and the camera are clocked apart, so frames are repeated and left out.
    """
    # A copy in memory, as the folder may be the host's.
    copy = shutil.copy(scene, '/run')
    take_format(pixel_format, output, width, height, field)
    player = subprocess.Popen(
        ['v4l2-ctl', '-d', output, '--stream-out-mmap=4', f'--stream-from={copy}',
         '--stream-loop'], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield
    finally:
        player.terminate()
        player.wait(timeout=30 * SLOWNESS)
