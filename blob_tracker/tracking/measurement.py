"""A bearing as the filter takes it, or why it is none."""

from __future__ import annotations

from math import isfinite, pi, sqrt

from blob_tracker.tracking.errors import PlatformGap, TrackingError
from blob_tracker.tracking.kalman import Measurement
from blob_tracker.tracking.pan_tilt import PanTilt
from blob_tracker.tracking.rotation import NO_TURN
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import numpy as np

STRAIGHT_UP_MRAD = 0.5 * pi / MRAD
# From 2 milliseconds of arc, which no camera sees, to half a turn, which says nothing.
LEAST_VARIANCE_MRAD2, MOST_VARIANCE_MRAD2 = 1e-10, 1e7
ASYMMETRY = 1e-9  # of a covariance, of its standard deviations' product: rounding of a product
# Of a covariance's determinant, of its diagonal's product: a correlation that rounding can tell
# from a perfect one.
LEAST_DETERMINANT = 1e-12


def measured(bearing: Bearing, pan_tilt: PanTilt | None) -> Measurement:
    """
    Return a bearing with how the camera stood.

    Parameters
    ----------
    bearing : Bearing
        In the camera's optical frame.
    pan_tilt : PanTilt or None
        How the camera is turned against the base.

    Returns
    -------
    Measurement
        Its variances are those of the bearing and of the pan/tilt's angles.

    Raises
    ------
    TrackingError
        If the bearing is none that can be, or the camera's direction at its stamp is not known.

    """
    azimuth, elevation = float(bearing.azimuth), float(bearing.elevation)
    if not (isfinite(azimuth) and abs(elevation) <= STRAIGHT_UP_MRAD):
        raise TrackingError(
            f'azimuth and elevation are {azimuth:g} and {elevation:g} mrad; they must be '
            f'finite, the elevation within +-{STRAIGHT_UP_MRAD:.1f}'
        )
    a, b, c = _checked_covariance(bearing)
    if pan_tilt is None:
        return Measurement(azimuth, elevation, a, b, c, NO_TURN)
    try:
        camera = pan_tilt.at(bearing.stamp_ns)
    except PlatformGap as gap:
        raise TrackingError(f'the bearing has no direction in the base: {gap}') from gap
    of_pan, of_tilt = (each / MRAD**2 for each in pan_tilt.variances_at(bearing.stamp_ns))
    return Measurement(azimuth, elevation, a + of_pan, b, c + of_tilt, camera)


def _checked_covariance(bearing: Bearing) -> tuple[float, float, float]:
    """Return the variance of azimuth, the covariance and the variance of elevation, mrad^2."""
    given = np.asarray(bearing.covariance, dtype=float)
    if given.shape != (2, 2):
        raise TrackingError(f"the bearing's covariance is {given.shape}; it must be (2, 2)")
    (a, b), (other, c) = given.tolist()
    # NaN and infinity pass no comparison that they must.
    if not (
        LEAST_VARIANCE_MRAD2 <= a <= MOST_VARIANCE_MRAD2
        and LEAST_VARIANCE_MRAD2 <= c <= MOST_VARIANCE_MRAD2
        and abs(b - other) <= ASYMMETRY * sqrt(a * c)
        and a * c - b * b > LEAST_DETERMINANT * a * c
    ):
        raise TrackingError(
            f"the bearing's covariance is {given.tolist()} mrad^2; it must be symmetric and "
            f'positive definite, each variance from {LEAST_VARIANCE_MRAD2:g} to '
            f'{MOST_VARIANCE_MRAD2:g}'
        )
    return a, b, c
