"""
Runs in the guest: an analogue camera's pictures, played into S-Video, arrive as fields.

The folder holds analogue.grey, and gets analogue.npz.
"""

from __future__ import annotations

from pathlib import Path
import time

from blob_tracker.capture import NoFrameError, V4l2Camera
from blob_tracker.types import Frame
import numpy as np
from numpy.typing import NDArray
from vm.guest_fields import S_VIDEO
from vm.hdmi_loop import CAPTURE, close_loop, NEXT_FRAME, OUTPUT, playing, SLOWNESS, v4l2_ctl
from vm.scene import ANALOGUE_HEIGHT, ANALOGUE_PICTURES, ANALOGUE_WIDTH

PATIENCE = 60.0 * SLOWNESS  # s; 2 on a quiet machine


def known_by(field: NDArray[np.uint8]) -> bytes:
    """Return what a field is known by: neither its first line, see the test, nor the last."""
    return field[1:ANALOGUE_HEIGHT // 2 - 1].tobytes()


def numbers(folder: Path) -> dict[bytes, int]:
    """Return the number of each field played."""
    pictures = np.fromfile(folder / 'analogue.grey', np.uint8).reshape(
        ANALOGUE_PICTURES, ANALOGUE_HEIGHT, ANALOGUE_WIDTH)
    return {
        known_by(picture[kind::2]): 2 * index + kind
        for index, picture in enumerate(pictures) for kind in (0, 1)
    }


def main(folder: Path) -> None:
    """Do all of it."""
    close_loop()
    v4l2_ctl(OUTPUT, '--set-output=1')
    v4l2_ctl(OUTPUT, '--set-standard=pal')
    v4l2_ctl(CAPTURE, f'--set-input={S_VIDEO}')
    v4l2_ctl(CAPTURE, '--set-standard=pal')
    played = numbers(folder)
    # The player repeats and leaves out pictures where the emulated processor is late: it goes
    # round until each field has come, in whatever order.
    came: dict[int, Frame] = {}
    with playing(
        folder / 'analogue.grey', 'GREY', width=ANALOGUE_WIDTH, height=ANALOGUE_HEIGHT,
        field='interlaced',
    ), V4l2Camera(CAPTURE, pixel_format='GREY') as camera:
        since = time.monotonic()
        while len(came) < len(played) and time.monotonic() - since < PATIENCE:
            try:
                frame = camera.read(NEXT_FRAME)
            except NoFrameError:
                continue
            number = played.get(known_by(frame.image))
            if number is not None:  # not the driver's own picture
                came.setdefault(number, frame)
        words = str(camera.fields)
    np.savez(
        folder / 'analogue.npz', images=np.array([each.image for each in came.values()]),
        numbers=np.array(list(came)), y0=np.array([each.y0 for each in came.values()]),
        words=words)
    v4l2_ctl(OUTPUT, '--set-output=0')
    v4l2_ctl(CAPTURE, '--set-input=0')
