"""The doubt about a narrow light in a picture that was interpolated from a colour mosaic."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.types import Location
import numpy as np

# A light of one colour is sampled in every other pixel, and what is interpolated between is no
# Gaussian of the same centre. The rms error beyond the noise, over all phases, of red lights of
# sigma 0.5 to 2 px in the luma of bilinear RGGB: 0.29, 0.23, 0.15, 0.07 and 0.00 px at a fitted
# sigma of 0.82, 0.92, 1.07, 1.21 and 1.38 px. White and green ones err less, and nobody tells.
HARMLESS_SIGMA_PX = 1.33  # fitted
ERROR_PER_SIGMA = 0.7  # px of error a px of sigma below it


def doubted(location: Location, binning: tuple[int, int]) -> Location:
    """
    Return a location with the error that the interpolation may have in its covariance.

    Parameters
    ----------
    location : Location
        Of a window whose pixels were interpolated from every other one.
    binning : (int, int)
        Of the window, along x and y.

    """
    narrow = HARMLESS_SIGMA_PX - location.sigma
    if narrow <= 0.0:
        return location
    error = ERROR_PER_SIGMA * narrow * np.array(binning, dtype=float)
    return replace(location, covariance=location.covariance + np.diag(error**2))
