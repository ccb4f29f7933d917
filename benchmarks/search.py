"""How long the segmenter takes for a frame, beside one subtraction and one search for its peak."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from statistics import median
from time import perf_counter

from benchmarks.clutter import amplitude
from blob_tracker.segmentation import Segmenter
from blob_tracker.simulation import in_step, Light, Scene, Sensor
from blob_tracker.types import Frame, Pixels, SensorNoise
import cv2
import numpy as np

Tick = Callable[[str], None]

SIZES = ((640, 480), (1920, 1200))
DEPTHS = {'uint8': 255, 'uint16': 4095}  # full scale, DN
POOL = 32  # frames in memory: 10 MB of the smallest, more than stays in a core's own cache
SNR, SIGMA = 30.0, 2.0
LOST, ACQUIRED, LOCKED = 'lost: no target', 'lost: a target appears', 'locked'
COMPONENTS = 'subtract + threshold + connectedComponentsWithStats'
WARM = 64  # frames after which the segmenter has locked, if it ever does
CUT = 5.0  # noise sigma above which a pixel belongs to a component


@dataclass(frozen=True)
class Row:
    """
    One path on one kind of frame.

    Parameters
    ----------
    size, depth, path : str
        'width x height', type of the pixels, and what is timed.
    seconds : float
        Of one frame: the median over the frames of a repeat, the median of all repeats. Where it
        is locked, of the means of a lit frame and the unlit one after it.
    reference : float
        Seconds of cv2.subtract and cv2.minMaxLoc of the same frames, likewise.
    ratio : float
        Median over the repeats of the one over the other.
    windows : float
        Share of the lit frames that gave a window, NaN where nothing is lit.

    """

    size: str
    depth: str
    path: str
    seconds: float
    reference: float
    ratio: float
    windows: float


def steps() -> int:
    """Return how many ticks `run` makes."""
    return len(SIZES) * len(DEPTHS)


def run(repeats: int, tick: Tick) -> list[Row]:
    """Return the rows of each size and depth."""
    rows = []
    for size in SIZES:
        for depth in DEPTHS:
            tick(f'search {size[0]} x {size[1]}, {depth}')
            rows += measure(size, depth, repeats)
    return rows


def measure(size: tuple[int, int], depth: str, repeats: int) -> list[Row]:
    """
    Return the rows of one size and depth.

    All take turns within each repeat, each over the whole pool, so that none finds its frames in
    the cache and a busy machine slows all alike.
    """
    empty = pool(size, DEPTHS[depth], False)
    lights = pool(size, DEPTHS[depth], True)
    cut = CUT * float(np.std(cv2.subtract(empty[2], empty[1], dtype=cv2.CV_32F)))
    lost, locked = Runner(empty), Runner(lights)
    for runner in (lost, locked):
        runner.go(WARM)
    times: dict[str, list[float]] = {}
    found: dict[str, list[float]] = {}
    for _ in range(repeats):
        reference = _each(empty, _subtract_and_search)
        turns = {
            LOST: (lost.go(POOL), []),
            ACQUIRED: _acquire(empty, lights),
            LOCKED: (of_pairs(locked.go(POOL)), locked.windows),
            COMPONENTS: (_each(empty, lambda a, b, c: _components(a, b, c, cut)), []),
        }
        times.setdefault('', []).append(median(reference))
        for path, (seconds, windows) in turns.items():
            times.setdefault(path, []).append(median(seconds))
            found.setdefault(path, []).extend(windows)
    return [
        Row(
            f'{size[0]} x {size[1]}',
            depth,
            path,
            median(times[path]),
            median(times['']),
            median(own / other for own, other in zip(times[path], times[''])),
            float(np.mean(found[path])) if found[path] else float('nan'),
        )
        for path in (LOST, ACQUIRED, LOCKED, COMPONENTS)
    ]


def pool(size: tuple[int, int], full_scale: int, lit: bool) -> list[Pixels]:
    """Return POOL frames of a textured wall, with a light that is where it was after them all."""
    scale = full_scale / 255.0
    noise = SensorNoise(gain=40.0 / scale, read_noise=0.7 * scale)
    scene = Scene(
        width=size[0],
        height=size[1],
        background=40.0 * scale,
        texture=8.0 * scale,
        sensor=Sensor(noise, full_scale.bit_length()),
    )
    if lit:
        light = Light(
            0.31 * size[0],
            0.37 * size[1],
            SIGMA,
            amplitude(scene, SNR),
            in_step(scene.rate),
            reach_x=3.0,
            reach_y=3.0,
            period=POOL / scene.rate,
        )
        scene = replace(scene, target=light)
    return [scene.frame(index) for index in range(POOL)]


class Runner:
    """
    A segmenter that goes round and round a pool of frames; the even ones are lit.

    Parameters
    ----------
    images : sequence of (h, w) arrays
        The pool.

    Attributes
    ----------
    windows : list of bool
        Whether each lit frame of the last round gave a window.

    """

    def __init__(self, images: Sequence[Pixels]) -> None:
        self.windows: list[bool] = []
        self._images = images
        self._segmenter = Segmenter()
        self._index = 0

    def go(self, count: int) -> list[float]:
        """Return the seconds of each of the next frames."""
        seconds, self.windows = [], []
        for index in range(self._index, self._index + count):
            frame = _frame(self._images[index % len(self._images)], index)
            start = perf_counter()
            window = self._segmenter.update(frame)
            seconds.append(perf_counter() - start)
            if index % 2 == 0:
                self.windows.append(window is not None)
        self._index += count
        return seconds


def _acquire(
    empty: Sequence[Pixels], lights: Sequence[Pixels]
) -> tuple[list[float], list[bool]]:
    """Return the seconds of a target's first frame and whether it gave a window at once."""
    seconds, windows = [], []
    for index in range(2, len(lights), 2):
        segmenter = Segmenter()
        segmenter.update(_frame(empty[index - 2], 0))
        segmenter.update(_frame(empty[index - 1], 1))
        frame = _frame(lights[index], 2)
        start = perf_counter()
        window = segmenter.update(frame)
        seconds.append(perf_counter() - start)
        windows.append(window is not None)
    return seconds, windows


def _frame(image: Pixels, index: int) -> Frame:
    """Return a frame of 60 a second."""
    full_scale = DEPTHS[str(image.dtype)]
    return Frame(image, 10**9 + index * 16_666_667, full_scale)


def of_pairs(seconds: Sequence[float]) -> list[float]:
    """Return the means of two each: the median of two kinds of frames would be of neither."""
    return [0.5 * (lit + unlit) for lit, unlit in zip(seconds[::2], seconds[1::2])]


def _each(
    images: Sequence[Pixels], call: Callable[[Pixels, Pixels, Pixels], object]
) -> list[float]:
    """Return the seconds of a call of each frame, the one before it, and a place to write."""
    seconds = []
    rise = np.empty_like(images[0])
    for before, after in zip(images, images[1:]):
        start = perf_counter()
        call(after, before, rise)
        seconds.append(perf_counter() - start)
    return seconds


def _subtract_and_search(lit: Pixels, unlit: Pixels, rise: Pixels) -> object:
    cv2.subtract(lit, unlit, dst=rise)
    return cv2.minMaxLoc(rise)


def _components(lit: Pixels, unlit: Pixels, rise: Pixels, cut: float) -> object:
    cv2.subtract(lit, unlit, dst=rise)
    return cv2.connectedComponentsWithStats((rise > cut).astype(np.uint8))
