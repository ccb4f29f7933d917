"""
Write docs/demo.gif: a light in the virtual lab, what is cut out of it, and the angle.

    python tools/moving_picture.py
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from blob_tracker import CameraModel, Frame
from blob_tracker.camera import pinhole_matrix
from blob_tracker.drawing import (
    blank, FOUND, GAP_PX, in_grey, LINE_PX, nearest_pixel, Picture, REJECTED, TEXT, write,
)
from blob_tracker.location import locate
from blob_tracker.segmentation import Segmenter
from blob_tracker.simulation import flashing_light, Glints, Scene, Sensor
from blob_tracker.types import Bearing, Pixels, SensorNoise, Window
import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

OUT = Path(__file__).parents[1] / 'docs' / 'demo.gif'
WIDTH, HEIGHT, RATE = 320, 240, 60.0  # px, px, Hz
FIRST, COUNT = 60, 180  # frames: after the light was confirmed, and for one way round
INTERVAL = 100  # ms a frame: every other pair is shown, three times slower than it was
WHITE = 200.0  # DN
INSET = 144  # px of the side of a zoomed window
STEP = 16.0  # DN of a shade: finer ones show the noise, of which a file cannot be made small
COLOURS = 32
NOISE = SensorNoise(gain=40.0, read_noise=0.7)


def scene() -> Scene:
    """Return a light that goes once round among glints, before a wall."""
    plain = flashing_light(
        width=WIDTH, height=HEIGHT, rate=RATE, period=COUNT / RATE, reach=0.6, sensor=Sensor(NOISE)
    )
    return replace(plain, elements=(Glints(),))


def main() -> None:
    """Write the picture."""
    shown = scene()
    camera = CameraModel(WIDTH, HEIGHT, pinhole_matrix(400.0, WIDTH, HEIGHT))
    segmenter = Segmenter()
    trail: deque[tuple[float, float]] = deque(maxlen=COUNT)
    window: Window | None = None
    bearing: Bearing | None = None
    pictures = []
    for index in range(FIRST + COUNT):
        image = shown.frame(index)
        found = segmenter.update(Frame(image, stamp_ns=shown.stamp_ns(index), saturation=255))
        if found is not None:
            window, place = found, locate(found, noise=NOISE)
            bearing = camera.bearing(place)
            trail.append((place.x, place.y))
        if index >= FIRST and index % 4 < 2:
            pictures.append(picture(image, window, bearing, trail, lit=found is not None))
    rgb = [Image.fromarray(each[:, :, ::-1]) for each in pictures]
    palette = rgb[0].quantize(COLOURS)
    first, *rest = [each.quantize(palette=palette, dither=Image.Dither.NONE) for each in rgb]
    first.save(OUT, save_all=True, append_images=rest, duration=INTERVAL, loop=0, optimize=True)


def picture(
    image: Pixels, window: Window | None, bearing: Bearing | None,
    trail: Iterable[tuple[float, float]], lit: bool,
) -> Picture:
    """Return a frame with the way of the light; beside it the last window and the angle."""
    frame = in_grey(_shades(image), 0.0, WHITE, 1.0)
    way = np.array([[nearest_pixel(x), nearest_pixel(y)] for x, y in trail], dtype=np.int32)
    cv2.polylines(frame, [way.reshape(-1, 1, 2)], False, REJECTED, 1)
    beside = blank(HEIGHT, 2 * INSET + 3 * GAP_PX)
    if window is not None and window.unlit is not None and bearing is not None:
        height, width = window.lit.shape
        first, last = (window.x0 - 1, window.y0 - 1), (window.x0 + width, window.y0 + height)
        cv2.rectangle(frame, first, last, FOUND if lit else TEXT, 1)
        for column, (name, pixels) in enumerate((('lit', window.lit), ('unlit', window.unlit))):
            left = GAP_PX + column * (INSET + GAP_PX)
            inset = in_grey(_shades(pixels), 0.0, WHITE, INSET / max(height, width))
            beside[LINE_PX:LINE_PX + inset.shape[0], left:left + inset.shape[1]] = inset
            write(beside, name, left, 0, TEXT)
        sigma = np.sqrt(np.diag(bearing.covariance))
        for line, (name, angle, deviation) in enumerate((
            ('azimuth', bearing.azimuth, sigma[0]), ('elevation', bearing.elevation, sigma[1]),
        )):
            text = f'{name:10}{angle:9.3f} +- {deviation:.3f} mrad'
            write(beside, text, GAP_PX, INSET + (2 + line) * LINE_PX, FOUND if lit else TEXT)
    return np.hstack([frame, beside])


def _shades(image: NDArray[Any]) -> NDArray[np.float32]:
    """Return an image with few shades of grey."""
    return np.asarray(STEP * np.round(image / STEP), dtype=np.float32)


if __name__ == '__main__':
    main()
