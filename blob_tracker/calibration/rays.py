"""What cameras saw of lights that moved before them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from blob_tracker.tracking.rays import directions
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAP = 10.0  # times the median: so far no light strays from the middle of its neighbours
DARK_S = 0.5  # s without a ray that are more than the dark bits of a code


@dataclass(frozen=True)
class Rays:
    """
    The rays of one camera to one light.

    Parameters
    ----------
    times : (n,) array
        Stamps of the camera's own clock, s, ascending.
    angles : (n, 2) array
        Azimuth and elevation, rad.
    covariance : (n, 2, 2) array
        Of these, rad^2.

    """

    times: Array
    angles: Array
    covariance: Array

    @cached_property
    def directions(self) -> Array:
        """Return unit vectors in the camera's optical frame, (n, 3)."""
        return directions(self.angles)

    def part(self, kept: NDArray[np.bool_]) -> Rays:
        """Return some of them."""
        return Rays(self.times[kept], self.angles[kept], self.covariance[kept])

    def at(self, times: Array, longest: float) -> Array:
        """
        Return the directions at other instants, on the chord between two rays.

        Parameters
        ----------
        times : (m,) array
            s of this camera's clock.
        longest : float
            Greatest time between the two rays, s.

        Returns
        -------
        (m, 3) array
            Unit vectors; NaN where no two rays are near enough.

        """
        after = np.clip(np.searchsorted(self.times, times), 1, len(self.times) - 1)
        start, end = self.times[after - 1], self.times[after]
        share = ((times - start) / np.where(end > start, end - start, np.inf))[:, None]
        seen = self.directions
        chord = (1.0 - share) * seen[after - 1] + share * seen[after]
        near = (end - start <= longest) & (times >= start) & (times <= end)
        chord[~near] = np.nan
        return np.asarray(chord / np.linalg.norm(chord, axis=1, keepdims=True))

    def without_leaps(self) -> Rays:
        """Return those that lie near the middle of the rays before and after, as most do."""
        if len(self.times) < 3:
            return self
        seen = self.directions
        bend = np.zeros(len(seen))
        middle = 0.5 * (seen[:-2] + seen[2:])
        bend[1:-1] = np.linalg.norm(seen[1:-1] - middle, axis=1)
        return self.part(bend <= LEAP * np.median(bend[1:-1]))

    def interval(self) -> float:
        """Return the time between two rays while the light is seen, s; NaN without such."""
        steps = np.diff(self.times)
        lit = steps[steps <= DARK_S]
        return float(lit.mean()) if len(lit) else np.nan
