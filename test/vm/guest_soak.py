"""
Runs in the guest: stream at full rate for long, and look at what grows meanwhile.

The folder gets soak.json.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
import time
from typing import Any

from blob_tracker.capture import Grabber, NoFrameError, V4l2Camera
import numpy as np
from vm.hdmi_loop import CAPTURE, close_loop, control, HEIGHT, NEXT_FRAME, SLOWNESS, WIDTH

SETTINGS: dict[str, Any] = {'device': CAPTURE, 'width': WIDTH, 'height': HEIGHT,
                            'pixel_format': 'GREY', 'buffers': 4}
SECONDS = float(os.environ['SOAK_SECONDS'])
BEGIN = 5.0  # s until the interpreter and its allocator have what they need
EVERY = 1.0  # s
LONGEST = 999  # ms, and above


def held() -> dict[str, int]:
    """Return what the process holds: open files, maps in all and of the camera, bytes."""
    maps = Path('/proc/self/maps').read_text().splitlines()
    pages = int(Path('/proc/self/statm').read_text().split()[1])
    return {'fds': len(os.listdir('/proc/self/fd')), 'maps': len(maps),
            'device_maps': sum(CAPTURE in line for line in maps),
            'rss': pages * os.sysconf('SC_PAGE_SIZE')}


def stream(seconds: float) -> dict[str, Any]:
    """Take every frame for so long."""
    samples: list[dict[str, int]] = []
    lags = [0] * 1000  # frames by ms; nothing in here may grow by itself
    best = LONGEST
    frames = silent = 0
    with V4l2Camera(**SETTINGS) as camera, Grabber(camera) as grabber:
        grabber.newest(NEXT_FRAME)
        first, began = camera.sequence, time.monotonic()
        sample_at = began + BEGIN
        last_ns = 0
        ordered = True
        while time.monotonic() < began + seconds:
            try:
                frame = grabber.newest(1.0 * SLOWNESS)
            except NoFrameError:
                silent += 1
                continue
            frames += 1
            ordered &= last_ns < frame.stamp_ns
            last_ns = frame.stamp_ns
            lag = min(LONGEST, max(0, (time.time_ns() - frame.stamp_ns) // 1_000_000))
            lags[lag] += 1
            best = min(best, lag)
            if time.monotonic() > sample_at:
                samples.append(held() | {'best_lag_ms': best})
                best = LONGEST
                sample_at += EVERY
        took = time.monotonic() - began
        return {
            'frames': frames, 'numbers': camera.sequence - first, 'drops': grabber.drops,
            'overruns': grabber.overruns, 'silent': silent, 'ordered': ordered, 'seconds': took,
            'frame_rate': camera.frame_rate, 'ring_s': camera.longest_wait,
            'median_lag_ms': int(np.searchsorted(np.cumsum(lags), frames / 2)),
            'lags_ms': {ms: count for ms, count in enumerate(lags) if count},
            'samples': samples}


def reopen(count: int = 10) -> dict[str, Any]:
    """Open and close the camera again and again."""
    def once() -> None:
        with V4l2Camera(**SETTINGS) as camera, Grabber(camera) as grabber:
            grabber.newest(NEXT_FRAME)

    once()
    before = held()
    for _ in range(count):
        once()
    return {'before': before, 'after': held()}


def main(folder: Path) -> None:
    """Do all of it."""
    close_loop()
    control(loop_video=0)
    found = stream(SECONDS)
    found['reopened'] = reopen()
    control(loop_video=1)
    (folder / 'soak.json').write_text(json.dumps(found, indent=1))
