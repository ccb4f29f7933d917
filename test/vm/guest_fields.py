"""
Runs in the guest: the fields of the driver's TV and S-Video inputs.

The folder gets fields.json.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from blob_tracker.capture import V4l2Camera
from blob_tracker.types import Frame
import numpy as np
from vm.hdmi_loop import CAPTURE, close_loop, control, NEXT_FRAME, v4l2_ctl

TV, S_VIDEO = 1, 2  # numbers of the inputs; 0 is HDMI
PICTURES = 8
# name -> input, standard, what is asked for
CASES: dict[str, tuple[int, str, str]] = {
    'TV, 525 lines': (TV, 'ntsc', ''),
    'S-Video, 625 lines': (S_VIDEO, 'pal', ''),
    'seq_tb': (S_VIDEO, 'pal', 'seq_tb'),
    'bottom': (S_VIDEO, 'pal', 'bottom'),
    'alternate': (S_VIDEO, 'pal', 'alternate'),
}


def shift(frame: Frame, next_one: Frame) -> int:
    """Return by how many pixels the middle line has moved to the right, around the edge."""
    first, second = (
        np.fft.rfft(each.image[len(each.image) // 2].astype(float)) for each in (frame, next_one))
    width = frame.image.shape[1]
    place = int(np.fft.irfft(second * first.conj(), width).argmax())
    return place if place < width // 2 else place - width


def seen(asked: str) -> dict[str, Any]:
    """Read a pattern that moves to the right, and one whose lines are white and black in turn."""
    control(test_pattern=0, horizontal_movement=6)  # fast
    with V4l2Camera(CAPTURE, pixel_format='GREY', fields=asked) as camera:
        count = PICTURES * camera.fields.per_picture
        frames = [camera.read(NEXT_FRAME) for _ in range(count)]
        found = {
            'fields': str(camera.fields), 'sensor_size': list(camera.sensor_size),
            'frame_rate': camera.frame_rate, 'pixel_aspect': camera.pixel_aspect,
            'per_buffer': camera.fields.per_buffer,
            'stamps': [frame.stamp_ns for frame in frames],
            'shapes': [list(frame.image.shape) for frame in frames],
            'y0': [frame.y0 for frame in frames],
            'binning': [list(frame.binning) for frame in frames],
            'shifts': [shift(*pair) for pair in zip(frames, frames[1:])],
        }
    control(test_pattern=15, horizontal_movement=3)  # alternating lines, no movement
    with V4l2Camera(CAPTURE, pixel_format='GREY', fields=asked) as camera:
        frames = [camera.read(NEXT_FRAME) for _ in range(2 * camera.fields.per_picture)]
    found['levels'] = [
        # The driver sends a signal for television sets in the first line.
        [frame.y0, int(frame.image[1:].min()), int(frame.image[1:].max())] for frame in frames]
    return found


def main(folder: Path) -> None:
    """Do all of it."""
    close_loop()
    control(loop_video=0)  # else S-Video, to which nothing is sent, shows noise
    found = {}
    for name, (number, standard, asked) in CASES.items():
        v4l2_ctl(CAPTURE, f'--set-input={number}')
        v4l2_ctl(CAPTURE, f'--set-standard={standard}')
        found[name] = seen(asked)
    control(test_pattern=0, loop_video=1)
    v4l2_ctl(CAPTURE, '--set-input=0')
    (folder / 'fields.json').write_text(json.dumps(found, indent=1))
