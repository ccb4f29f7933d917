"""Runs in the guest: what is played into vivid's HDMI output arrives at its HDMI input."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import shutil
import subprocess
import time

CAPTURE, OUTPUT = '/dev/video0', '/dev/video1'
WIDTH, HEIGHT = 320, 240
SIGNAL = 1280, 720  # px
# CTA-861 format 60, 1280x720p24: the slowest there is, for the sake of the emulated processors.
# Without its scalers the driver sends and takes the top left WIDTH x HEIGHT of it.
TIMINGS = ('width=1280,height=720,interlaced=0,polarities=3,pixelclock=59400000,'
           'hfp=1760,hs=40,hbp=220,vfp=5,vs=5,vbp=20')
FRAME_RATE = 24.0
# Of the host, as `support.slowness` has it: all limits of the guest are stretched by it.
SLOWNESS = float(os.environ.get('SLOWNESS', 1.0))
NEXT_FRAME = 5.0 * SLOWNESS  # s; a twenty-fourth on a quiet machine


def v4l2_ctl(device: str, *options: str) -> None:
    """Run v4l2-ctl on a device."""
    subprocess.run(['v4l2-ctl', '-d', device, *options], check=True, timeout=30 * SLOWNESS,
                   stdout=subprocess.DEVNULL)


def control(device: str = CAPTURE, **settings: int | str) -> None:
    """Set controls of a capture device."""
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


def close_loop(capture: str = CAPTURE, output: str = OUTPUT) -> None:
    """Give both ends the same timings and join them; vivid writes no text into the picture."""
    for device in (output, capture):
        v4l2_ctl(device, f'--set-dv-bt-timings={TIMINGS}')
    v4l2_ctl(output, '-c', 'enable_output_scaler=0')
    # Stamps at the start of the frame: those at its end lie 0.9 frames ahead of the delivery,
    # as vivid has the picture ready when the frame begins.
    control(
        capture, enable_capture_scaler=0, loop_video=1, osd_text_mode=2, timestamp_source=1)


@contextmanager
def playing(
    scene: Path, pixel_format: str, output: str = OUTPUT, width: int = WIDTH, height: int = HEIGHT
) -> Iterator[None]:
    """
    Play a raw file into the output device, again and again.

    The player and the camera are clocked apart, so frames are repeated and left out.
    """
    # A copy in memory, as the folder may be the host's.
    copy = shutil.copy(scene, '/run')
    # The driver keeps the region of an earlier, smaller picture.
    region = f'left=0,top=0,width={width},height={height}'
    v4l2_ctl(output, f'--set-fmt-video-out=width={width},height={height},'
                     f'pixelformat={pixel_format}',
             f'--set-selection-output=target=compose,{region}',
             f'--set-selection-output=target=crop,{region}')
    player = subprocess.Popen(
        ['v4l2-ctl', '-d', output, '--stream-out-mmap=4', f'--stream-from={copy}',
         '--stream-loop'], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield
    finally:
        player.terminate()
        player.wait(timeout=30 * SLOWNESS)
