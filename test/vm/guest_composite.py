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
from vm.guest_fields import S_VIDEO
from vm.hdmi_loop import CAPTURE, close_loop, NEXT_FRAME, OUTPUT, playing, SLOWNESS, v4l2_ctl
from vm.scene import ANALOGUE_HEIGHT, ANALOGUE_WIDTH

FIELDS = 60
PATIENCE = 8.0 * SLOWNESS  # s for each field; all come in 2 on a quiet machine


def main(folder: Path) -> None:
    """Do all of it."""
    close_loop()
    v4l2_ctl(OUTPUT, '--set-output=1')
    v4l2_ctl(OUTPUT, '--set-standard=pal')
    v4l2_ctl(CAPTURE, f'--set-input={S_VIDEO}')
    v4l2_ctl(CAPTURE, '--set-standard=pal')
    frames: list[Frame] = []
    with playing(
        folder / 'analogue.grey', 'GREY', width=ANALOGUE_WIDTH, height=ANALOGUE_HEIGHT,
        field='interlaced',
    ), V4l2Camera(CAPTURE, pixel_format='GREY') as camera:
        since = time.monotonic()
        while len(frames) < FIELDS and time.monotonic() - since < PATIENCE:
            try:
                frames.append(camera.read(NEXT_FRAME))
                since = time.monotonic()
            except NoFrameError:
                pass
        words = str(camera.fields)
    np.savez(
        folder / 'analogue.npz', images=np.array([each.image for each in frames]),
        stamps=np.array([each.stamp_ns for each in frames]),
        y0=np.array([each.y0 for each in frames]), words=words)
    v4l2_ctl(OUTPUT, '--set-output=0')
    v4l2_ctl(CAPTURE, '--set-input=0')
