"""The frames of a source that costs nothing: drawn beforehand, sent on time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import lru_cache
import json
from multiprocessing import get_context
import sys
import time
from typing import Any

from blob_tracker.camera import CameraModel, pinhole_matrix
from blob_tracker.simulation import flashing_light
from blob_tracker.types import Pixels

COUNT = 32  # frames that are drawn, even, and shown to and fro: the light never jumps
PERIOD = 300.0  # s of its path: it all but stands still, as what is measured is no tracking
FOCAL_LENGTH = 600.0  # px
FRAME_ID = 'camera_optical_frame'


@lru_cache(maxsize=1)  # a stream of no length has them drawn before anything is measured
def draw(width: int, height: int, rate: float) -> list[Pixels]:
    """Return the frames of one turn, lit in the even places: a flash in step with the frames."""
    # In a process of its own: the memory of the lab is none of the nodes'.
    with ProcessPoolExecutor(1, get_context('spawn')) as other:
        return other.submit(_draw, width, height, rate).result()


def _draw(width: int, height: int, rate: float) -> list[Pixels]:
    """Return those of `draw`."""
    scene = flashing_light(width=width, height=height, rate=rate, period=PERIOD)
    there = [scene.frame(index) for index in range(COUNT)]
    return there + there[-2:0:-1]


def camera_model(width: int, height: int) -> CameraModel:
    """Return the camera that took them."""
    return CameraModel(width, height, pinhole_matrix(FOCAL_LENGTH, width, height))


def send(
    frames: list[Pixels], rate: float, seconds: float, publish: Callable[[Pixels, int], int],
    wait: Callable[[float], None] = time.sleep,
) -> list[tuple[int, int, bool]]:
    """
    Hand the frames out at a rate.

    Parameters
    ----------
    frames : list of (h, w) array
        Of one turn, the even ones lit.
    rate, seconds : float
        How many a second and for how long.
    publish : callable
        Sends pixels with a stamp, ns; returns the monotonic time, ns, when they left its hand.
    wait : callable
        Takes so many s.

    Returns
    -------
    list of (int, int, bool)
        Stamp, time and whether lit, of each.

    """
    sent = []
    first_ns = time.time_ns()
    for index in _paced(rate, seconds, wait):
        place = index % len(frames)
        # A camera's stamps are regular, however late its frames are taken off it.
        stamp_ns = first_ns + int(1e9 * index / rate)
        sent.append((stamp_ns, publish(frames[place], stamp_ns), place % 2 == 0))
    return sent


def _paced(
    rate: float, seconds: float, wait: Callable[[float], None]
) -> Iterator[int]:
    """Yield the number of each frame when it is due; one that is late does not move the next."""
    began = time.monotonic()
    for index in range(int(rate * seconds)):
        pause = began + index / rate - time.monotonic()
        if pause > 0.0:
            wait(pause)
        yield index


def report(result: object) -> None:
    """Give a result to the process that waits for it."""
    print(json.dumps(result), flush=True)


def requests() -> Iterator[Any]:
    """Yield what the process that started this one asks for, until it has no more need of it."""
    for line in sys.stdin:
        yield json.loads(line)
