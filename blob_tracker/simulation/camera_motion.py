"""How a camera moves: from places in the scene to places in the picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray


class CameraMotion(Protocol):
    """A camera, which may move."""

    def motion(self, index: int, shape: tuple[int, int]) -> NDArray[np.float64]:
        """Return the (2, 3) map of a frame of the shape (h, w), px."""


@dataclass(frozen=True)
class Stepping:
    """
    A camera that steps back and forth between two poses: it has moved in the even frames.

    Parameters
    ----------
    shift_x, shift_y : float
        How far the picture moves, px.
    turn : float
        How far it turns about its middle, degrees.

    Examples
    --------
    How far the picture has moved in three frames:

    >>> camera = Stepping(shift_x=3.0)
    >>> [camera.motion(index, (480, 640))[0, 2].item() for index in (0, 1, 2)]  # px
    [3.0, 0.0, 3.0]

    """

    shift_x: float = 0.0
    shift_y: float = 0.0
    turn: float = 0.0

    def motion(self, index: int, shape: tuple[int, int]) -> NDArray[np.float64]:
        """Return the (2, 3) map of a frame, px; the identity in the odd ones."""
        part = 1.0 if index % 2 == 0 else 0.0
        return moved(part * self.shift_x, part * self.shift_y, part * self.turn, shape)


@dataclass(frozen=True)
class Drifting:
    """
    A camera that goes around in a circle, and shakes on the way.

    On a circle its speed is the same in every frame, and its direction every one.

    Parameters
    ----------
    speed : float
        Of the picture along the circle, px a frame.
    radius : float
        Of the circle, px.
    shake : float
        Amplitude of a faster motion across it, px: speed / 4 px at 0.11 of the frame rate.
    turn : float
        Greatest turn to either side, degrees.
    turn_frames : float
        Frames in which it turns there and back.

    Examples
    --------
    A frame later the picture has moved by the speed:

    >>> camera = Drifting(speed=2.0)
    >>> before, after = (camera.motion(index, (480, 640))[:, 2] for index in (0, 1))
    >>> round(float(np.hypot(*(after - before))), 1)  # px
    2.0

    """

    speed: float
    radius: float = 50.0
    shake: float = 0.0
    turn: float = 0.0
    turn_frames: float = 90.0

    def motion(self, index: int, shape: tuple[int, int]) -> NDArray[np.float64]:
        """Return the (2, 3) map of a frame, px."""
        angle = index * self.speed / self.radius
        quick = 2.0 * np.pi * 0.11 * index
        x = self.radius * np.cos(angle) + self.shake * np.sin(quick)
        y = self.radius * np.sin(angle) + self.shake * np.cos(1.3 * quick)
        turn = self.turn * np.sin(2.0 * np.pi * index / self.turn_frames)
        return moved(float(x), float(y), float(turn), shape)


def moved(x: float, y: float, turn: float, shape: tuple[int, int]) -> NDArray[np.float64]:
    """Return the (2, 3) map of a shift in px and a turn about the middle in degrees."""
    middle = (0.5 * (shape[1] - 1), 0.5 * (shape[0] - 1))
    motion = np.array(cv2.getRotationMatrix2D(middle, turn, 1.0), dtype=np.float64)
    motion[:, 2] += (x, y)
    return motion
