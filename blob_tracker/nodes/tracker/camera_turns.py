"""How the camera is turned in the base, by TF."""

from __future__ import annotations

from math import atan2, hypot

from blob_tracker.ros.endpoints.transforms import Transforms
from blob_tracker.tracking import PlatformGap
from blob_tracker.transforms import NoTransform, Transform
from blob_tracker.transforms.transform import inverse, product
import numpy as np
from numpy.typing import NDArray

HALF_NS = 5_000_000  # ns: half the time over which a rate is taken, an interval of 100 Hz


class CameraTurns:
    """
    A `PanTilt` that asks TF; nothing is extrapolated.

    Parameters
    ----------
    transforms : Transforms
        What has come.
    base : str
        The frame that does not turn with the camera.

    Attributes
    ----------
    camera : str
        The frame of the rays.
    sigma : float
        Standard deviation of the turn about each axis, rad.

    """

    def __init__(self, transforms: Transforms, base: str) -> None:
        self.camera = ''
        self.sigma = 0.0
        self._transforms, self._base = transforms, base
        self._found: tuple[str, int, Transform] | None = None  # of `awaits`, for the next `at`

    def awaits(self, stamp_ns: int) -> bool:
        """Tell whether the turn at a stamp, ns, is not known and may come."""
        self._found = None
        try:
            found = self._transforms.lookup(self.camera, self._base, stamp_ns)
        except NoTransform as gap:
            return gap.may_come
        self._found = self.camera, stamp_ns, found.transform
        return False

    def at(self, stamp_ns: int) -> NDArray[np.float64]:
        """Return how the camera is turned, see `PanTilt`."""
        found, self._found = self._found, None
        if found is not None and found[:2] == (self.camera, stamp_ns):
            return found[2].matrix
        return self._lookup(stamp_ns).matrix

    def rate_at(self, stamp_ns: int) -> NDArray[np.float64]:
        """Return how fast it turns, from a little before to a little after, or until then."""
        try:
            after_ns, after = stamp_ns + HALF_NS, self._lookup(stamp_ns + HALF_NS)
        except PlatformGap:
            after_ns, after = stamp_ns, self._lookup(stamp_ns)
        before_ns = after_ns - 2 * HALF_NS
        x, y, z, w = product(after, inverse(self._lookup(before_ns))).rotation
        length = hypot(x, y, z)
        if length == 0.0:
            return np.zeros(3)
        angle = 2.0 * atan2(length, abs(w)) * (1.0 if w >= 0.0 else -1.0)
        return np.array([x, y, z]) * (angle / length / (1e-9 * (after_ns - before_ns)))

    def variances_at(self, stamp_ns: int) -> tuple[float, float]:
        """Return the variances that it adds, see `PanTilt`."""
        return self.sigma**2, self.sigma**2

    def _lookup(self, stamp_ns: int) -> Transform:
        """Return how the camera lies in the base."""
        try:
            return self._transforms.lookup(self.camera, self._base, stamp_ns).transform
        except NoTransform as gap:
            raise PlatformGap(self._transforms.explain(gap)) from None
