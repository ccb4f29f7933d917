"""
A process in which a source tree's segmenter has many lights, and tells what they cost.

`python .../many.py` in the folder of any tree: its own package runs. It prints the processor time
of a frame, s, with 16 coded lights at 752 x 480, and with 1000 stars in the mode steady at
1920 x 1200; null where the tree cannot do that.
"""

from __future__ import annotations

from importlib import import_module
from itertools import product
import json
import os
from statistics import median
import sys
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

LIGHTS, BITS, RATE = 16, 15, 60.0  # Hz
STARS = 1000
FRAMES, LAST = 120, 60  # that are shown, and of them those that count
SIGMA_PX, PEAK_DN, LEVEL_DN = 1.6, 120.0, 20.0
PATCH = np.arange(-8, 9)


def main() -> None:
    """Measure both."""
    sys.path[0] = os.getcwd()  # in place of the folder of this file
    print(json.dumps([_seconds(_coded), _seconds(_stars)]), flush=True)


def _seconds(play: Any) -> float | None:
    """Return the processor time of a frame; None where the tree has no such thing."""
    try:
        segmenter, images = play(import_module('blob_tracker.segmentation'))
        frame = import_module('blob_tracker.types').Frame
        times = []
        for index in range(FRAMES):
            shown = frame(images[index % len(images)], round(1e9 * index / RATE), 255)
            began = time.process_time()
            segmenter.sightings(shown)
            times.append(time.process_time() - began)
    except (AttributeError, ImportError, TypeError, ValueError):
        return None
    return median(times[-LAST:])


def _coded(room: Any) -> tuple[Any, list[NDArray[np.uint8]]]:
    """Return a segmenter that knows the codes, and the frames of a period."""
    random = np.random.default_rng(1)
    codes: dict[str, str] = {}
    kinds: set[str] = set()
    while len(codes) < LIGHTS:  # one that is no other shifted
        bits = ''.join('1' if bit else '0' for bit in random.random(BITS) < 0.5)
        kind = min(bits[shift:] + bits[:shift] for shift in range(BITS))
        if 6 <= bits.count('1') <= 9 and '0000' not in 2 * bits and kind not in kinds:
            kinds.add(kind)
            codes[f'light{len(codes)}'] = bits
    places = [(90.0 + 190.0 * column, 70.0 + 110.0 * row)
              for row, column in product(range(4), range(4))]
    images = [
        _drawn((480, 752), [
            place for place, bits in zip(places, codes.values()) if bits[index] == '1'
        ], random)
        for index in range(BITS)
    ]
    flash = room.flash_by_name('coded', codes=codes, frames_per_bit=1)
    return room.Segmenter(flash=flash), images


def _stars(room: Any) -> tuple[Any, list[NDArray[np.uint8]]]:
    """Return a segmenter in the mode steady, and a sky seen four times."""
    random = np.random.default_rng(2)
    places = list(zip(random.uniform(20, 1900, STARS), random.uniform(20, 1180, STARS)))
    images = [_drawn((1200, 1920), places, random) for _ in range(4)]
    return room.Segmenter(flash=room.flash_by_name('steady')), images


def _drawn(
    shape: tuple[int, int], places: list[tuple[float, float]], random: np.random.Generator
) -> NDArray[np.uint8]:
    """Return a frame with lights at these places."""
    image = LEVEL_DN + random.normal(0.0, 0.9, shape)
    for x, y in places:
        rows, columns = round(y) + PATCH, round(x) + PATCH
        along = np.exp(-0.5 * ((columns - x) / SIGMA_PX)**2)
        image[rows[0]:rows[-1] + 1, columns[0]:columns[-1] + 1] += PEAK_DN * np.outer(
            np.exp(-0.5 * ((rows - y) / SIGMA_PX)**2), along
        )
    return np.rint(image).clip(0, 255).astype(np.uint8)


if __name__ == '__main__':
    main()
