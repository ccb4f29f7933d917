"""What an element of a scene is told of the frame that it is drawn into."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

Places = TypeVar('Places', float, NDArray[np.float64])


@dataclass(frozen=True)
class Shot:
    """
    One exposure.

    Parameters
    ----------
    index : int
        Of the frame.
    time : float
        Middle of the exposure, s; frame 0 has 0. Of the middle row, where each has its own.
    interval, exposure : float
        Time from frame to frame and length of the exposure, s.
    motion : (2, 3) array
        From places in the scene to places in the picture, px.
    row_time : float
        From the exposure of a row to that of the next, s; 0 for a global shutter.
    middle_row : float
        The row that is exposed about `time`.
    aperture : float
        Side of the light-sensitive middle of a pixel, px.
    streaks : bool
        Whether a light that moves leaves its streak; else it stands still within an exposure.

    """

    index: int
    time: float
    interval: float
    exposure: float
    motion: NDArray[np.float64]
    row_time: float = 0.0
    middle_row: float = 0.0
    aperture: float = 1.0
    streaks: bool = False

    def place(self, x: Places, y: Places) -> tuple[Places, Places]:
        """Return where in the picture places of the scene are, px."""
        (a, b, c), (d, e, f) = self.motion.tolist()
        return a * x + b * y + c, d * x + e * y + f

    def time_of(self, row: Places) -> Places:
        """Return the middle of the exposure of rows, which may lie outside of the picture, s."""
        return self.time + self.row_time * (row - self.middle_row)


class Element(Protocol):
    """Something in a scene."""

    def draw(self, picture: NDArray[np.float32], shot: Shot) -> None:
        """Change the (h, w) mean signal of the picture, DN."""
