"""Where a tracker expects the target in the next frame."""

from __future__ import annotations

import math
from typing import NamedTuple

from blob_tracker.types import Frame
import numpy as np
from numpy.typing import NDArray

GATE_SIGMA = 4.0  # of a place in two dimensions: one in 3000 is further off


class Expectation(NamedTuple):
    """
    Where a tracker expects the target.

    Parameters
    ----------
    x, y : float
        px, full unbinned sensor.
    covariance : (2, 2) array
        px^2, order x, y.

    Examples
    --------
    A place on the sensor, as a frame that is binned by 2 and begins at x = 200 px shows it:

    >>> expected = Expectation(320.5, 240.5, np.diag([4.0, 4.0]))
    >>> frame = Frame(np.zeros((240, 200), np.uint8), 0, saturation=255, x0=200, binning=(2, 2))
    >>> place = expected.in_frame(frame)
    >>> place.x, place.y, place.covariance[0, 0].item()  # px, px^2
    (60.0, 120.0, 1.0)
    >>> place.inside(frame.image.shape)
    True

    """

    x: float
    y: float
    covariance: NDArray[np.float64]

    def in_frame(self, frame: Frame) -> Expectation:
        """Return it in px of a frame, of its crop and binning (REP 104)."""
        across, down = frame.binning
        return Expectation(
            (self.x - frame.x0 + 0.5) / across - 0.5,
            (self.y - frame.y0 + 0.5) / down - 0.5,
            self.covariance / np.outer((across, down), (across, down)),
        )

    @property
    def gate_radius_px(self) -> float:
        """How far from there the target may be, px: NaN where the covariance is none."""
        (a, b), (_, c) = self.covariance.tolist()
        if not (a >= 0.0 and c >= 0.0 and b * b <= a * c):
            return math.nan
        return GATE_SIGMA * math.sqrt(0.5 * (a + c) + math.hypot(0.5 * (a - c), b))

    def inside(self, shape: tuple[int, int]) -> bool:
        """Tell whether it lies in a frame of (h, w); not where a number of it is none."""
        return (
            -0.5 <= self.x < shape[1] - 0.5
            and -0.5 <= self.y < shape[0] - 0.5
            and self.gate_radius_px < math.inf
        )
