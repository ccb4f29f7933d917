"""What an element of a scene is told of the frame that it is drawn into."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Shot:
    """
    One exposure.

    Parameters
    ----------
    index : int
        Of the frame.
    time : float
        Middle of the exposure, s; frame 0 has 0.
    interval, exposure : float
        Time from frame to frame and length of the exposure, s.
    motion : (2, 3) array
        From places in the scene to places in the picture, px.

    """

    index: int
    time: float
    interval: float
    exposure: float
    motion: NDArray[np.float64]

    def place(self, x: float, y: float) -> tuple[float, float]:
        """Return where in the picture a place of the scene is, px."""
        (a, b, c), (d, e, f) = self.motion.tolist()
        return a * x + b * y + c, d * x + e * y + f


class Element(Protocol):
    """Something in a scene."""

    def draw(self, picture: NDArray[np.float32], shot: Shot) -> None:
        """Change the (h, w) mean signal of the picture, DN."""
