"""The video of what was seen: marks where the light is, and the reason where there is none."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.commands.track.annotated import MARK_PX, NARROWEST_PX, Video
from blob_tracker.commands.track.outcome import Outcome
from blob_tracker.types import Frame, Location
import cv2
import numpy as np

X, Y = 40.0, 20.0


def is_green(picture: np.ndarray) -> np.ndarray:
    """Tell which pixels are those of a mark, whatever the codec made of them."""
    blue, green, red = np.moveaxis(picture.astype(int), 2, 0)
    return (green > blue + 60) & (green > red + 60)


def test_each_frame_is_there_with_its_mark(tmp_path: Path) -> None:
    """At the rate of the stamps; a ring about the light, other words where there is none."""
    frames = [Frame(np.full((60, 80), 30, np.uint16), k * 40_000_000, 4095) for k in range(3)]
    there = Location(X, Y, 0.01 * np.eye(2), 100.0, 10.0, 1.5, 50.0, 1.0, 0)
    video = Video(tmp_path / 'v.mp4')
    video.add([Outcome('0', frames[0], 'port', there)])
    video.add([Outcome('1', frames[1], reason='nothing lit up: ' + 'no flash at all, ' * 9)])
    video.add([Outcome('2', frames[2], 'port', there), Outcome('2', frames[2], 'red', there)])
    video.close()
    read = cv2.VideoCapture(str(tmp_path / 'v.mp4'))
    assert read.get(cv2.CAP_PROP_FPS) == 25.0
    pictures = [read.read()[1] for _ in frames]
    assert not read.read()[0]
    scale = NARROWEST_PX // 80
    rows, columns = np.nonzero(is_green(pictures[0])[:60 * scale, :])
    # The name stands to the right of the ring, and above it.
    assert abs(columns.min() - ((X + 0.5) * scale - MARK_PX)) < 4
    assert abs(rows.max() - (Y + 0.5) * scale) <= MARK_PX + 2
    assert not is_green(pictures[1]).any() and is_green(pictures[2]).any()


def test_a_single_frame_is_a_video(tmp_path: Path) -> None:
    """Nobody knows its rate then."""
    video = Video(tmp_path / 'v.mp4')
    video.add([Outcome('0', Frame(np.zeros((61, 81, 3), np.uint8), 0, 255, layout='rgb'))])
    video.close()
    assert cv2.VideoCapture(str(tmp_path / 'v.mp4')).read()[0]
