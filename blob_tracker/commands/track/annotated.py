"""A video of what was seen: each frame with the place of the light, its angle, or the reason."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from blob_tracker.colour import in_channel
from blob_tracker.commands.sources import SourceError
from blob_tracker.commands.track.outcome import Outcome
from blob_tracker.drawing import (
    blank, FOUND, GAP_PX, in_grey, LINE_PX, nearest_pixel, PAPER, Picture, REJECTED, TEXT, wrap,
    write,
)
from blob_tracker.types import BAYER, Frame
import cv2
import numpy as np

NARROWEST_PX, WIDEST_PX, HIGHEST_PX = 480, 1280, 960  # px: small frames grow, large ones shrink
LINES = 4  # of text below the frame
TRAIL = 120  # places that stay in sight
MARK_PX = 9  # px: arms of the cross
DIMMEST_WHITE_DN = 32.0
RATES = 1.0, 120.0  # Hz, of the video
UNKNOWN_RATE = 25.0  # Hz
FORMAT = 'mp4v'


class Video:
    """
    Write a frame of a video for each frame.

    Parameters
    ----------
    path : Path
        The video to write.

    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._writer: cv2.VideoWriter | None = None
        self._first: tuple[Frame, Picture] | None = None  # until the next tells the rate
        self._white = DIMMEST_WHITE_DN
        self._trails: dict[str, deque[tuple[float, float]]] = {}

    def add(self, outcomes: Sequence[Outcome]) -> None:
        """Draw a frame with all that came of it."""
        frame = outcomes[0].frame
        for each in outcomes:
            if each.location is not None:
                trail = self._trails.setdefault(each.light, deque(maxlen=TRAIL))
                trail.append((each.location.x, each.location.y))
        picture = self._draw(frame, outcomes)
        if self._writer is not None:
            self._write(picture)
        elif self._first is None:
            self._first = frame, picture
        else:
            before, first = self._first
            apart = (frame.stamp_ns - before.stamp_ns) / 1e9
            self._open(first, min(max(1.0 / apart, RATES[0]), RATES[1]) if apart > 0.0 else 0.0)
            self._write(picture)

    def close(self) -> None:
        """End the video."""
        if self._writer is None and self._first is not None:
            self._open(self._first[1], 0.0)
        if self._writer is not None:
            self._writer.release()

    def _open(self, first: Picture, rate: float) -> None:
        height, width = first.shape[:2]
        self._size = width, height
        code = cv2.VideoWriter.fourcc(*FORMAT)
        self._writer = cv2.VideoWriter(str(self._path), code, rate or UNKNOWN_RATE, self._size)
        if not self._writer.isOpened():
            raise SourceError(f'{self._path} cannot be written: this OpenCV has no MPEG-4')
        self._write(first)

    def _write(self, picture: Picture) -> None:
        width, height = self._size
        if picture.shape[:2] != (height, width):  # frames of another size than the first
            picture = np.asarray(cv2.resize(picture, self._size), dtype=np.uint8)
        assert self._writer is not None
        self._writer.write(picture)

    def _draw(self, frame: Frame, outcomes: Sequence[Outcome]) -> Picture:
        """Return the frame with its marks, above lines of text; sides are even."""
        layout = 'grey' if frame.layout in BAYER else frame.layout
        image = in_channel(replace(frame, layout=layout), 'luma').image
        height, width = image.shape
        scale = min(WIDEST_PX / width, HIGHEST_PX / height)
        if scale >= 1.0:
            scale = float(min(-(-NARROWEST_PX // width), int(scale)))
        self._white = max(self._white, float(image.max()))
        shown = in_grey(image, 0.0, self._white, scale)
        for trail in self._trails.values():
            line = np.array([_pixel(frame, x, y, scale) for x, y in trail], dtype=np.int32)
            cv2.polylines(shown, [line.reshape(-1, 1, 2)], False, REJECTED, 1, cv2.LINE_AA)
        for each in outcomes:
            if each.location is not None:
                place = _pixel(frame, each.location.x, each.location.y, scale)
                cv2.drawMarker(shown, place, FOUND, cv2.MARKER_CROSS, 2 * MARK_PX, 1)
                if each.light:
                    write(
                        shown, each.light, place[0] + MARK_PX, place[1] - LINE_PX, FOUND,
                        outlined=True,
                    )
        words = blank(LINES * LINE_PX + GAP_PX, shown.shape[1])
        write(words, outcomes[0].name, GAP_PX, 0, TEXT)
        room = shown.shape[1] - 2 * GAP_PX
        lines = [(line, each) for each in outcomes for line in wrap(_say(each), room)]
        for number, (text, each) in enumerate(lines[:LINES - 1], start=1):
            colour = REJECTED if each.location is None else FOUND
            write(words, text, GAP_PX, number * LINE_PX, colour)
        picture = np.vstack([shown, words])
        odd = [(0, side % 2) for side in picture.shape[:2]]
        return np.pad(picture, [*odd, (0, 0)], constant_values=PAPER[0])


def _pixel(frame: Frame, x: float, y: float, scale: float) -> tuple[int, int]:
    """Return the pixel of the picture for a place on the sensor."""
    across = (x - frame.x0 + 0.5) / frame.binning[0]
    down = (y - frame.y0 + 0.5) / frame.binning[1]
    return nearest_pixel(across * scale - 0.5), nearest_pixel(down * scale - 0.5)


def _say(outcome: Outcome) -> str:
    """Return what came of a frame in words."""
    location, bearing = outcome.location, outcome.bearing
    if location is None:
        return outcome.reason
    light = f'{outcome.light}: ' if outcome.light else ''
    x, y = np.sqrt(location.covariance.diagonal())
    words = f'{light}x {location.x:.2f} +- {x:.2f}, y {location.y:.2f} +- {y:.2f} px'
    if bearing is not None:
        across, up = np.sqrt(bearing.covariance.diagonal())
        words = (
            f'{light}az {bearing.azimuth:.2f} +- {across:.2f}, el {bearing.elevation:.2f} '
            f'+- {up:.2f} mrad'
        )
    return f'{words}, SNR {location.snr:.0f}'
