"""What every method is given, numbers that it can work on, and what it has to give back."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.estimates import Failure
from blob_tracker.location.sites import ABSENT_DN
import numpy as np
from numpy.typing import NDArray

LARGEST_DN = 1e9  # DN: no sensor counts so far, and its fourth power is still a number
LEAST_ROUND = 1.0 - 1e-9  # of an ellipse's correlation squared: beyond it rounding decides
_NONE, _NOT_FINITE = int(Failure.NONE), int(Failure.NOT_FINITE)
_SATURATED, _FLAT = int(Failure.SATURATED), int(Failure.FLAT)
_OUTSIDE, _NOT_CONVERGED = int(Failure.OUTSIDE), int(Failure.NOT_CONVERGED)
_VAGUE = int(Failure.VAGUE)
EVEN = 1.0 / 12.0  # variance of a place that is anywhere in a window, over its size squared


@kernel
def flag_invalid(
    lit: Array, unlit: Array, saturation: float, invalid: NDArray[np.uint8]
) -> bool:
    """Flag the windows that no method can work on; tell whether there are such."""
    found = False
    for n in range(lit.shape[0]):
        low, high = math.inf, -math.inf
        finite = True
        for j in range(lit.shape[1]):
            for i in range(lit.shape[2]):
                value = lit[n, j, i]
                # An unlit window may well be flat; it may not hold NaN.
                finite = finite and (
                    abs(unlit[n, j, i]) <= LARGEST_DN or unlit[n, j, i] == ABSENT_DN
                )
                if value == ABSENT_DN:
                    continue
                finite = finite and abs(value) <= LARGEST_DN
                low = min(low, value)
                high = max(high, value)
        if not finite:
            invalid[n] = _NOT_FINITE
        elif low >= saturation:
            invalid[n] = _SATURATED
        elif low == high:
            invalid[n] = _FLAT
        found = found or invalid[n] != _NONE
    return found


@kernel
def validate(
    x: Array,
    y: Array,
    covariance: Array,
    amplitude: Array,
    background: Array,
    sigma: Array,
    snr: Array,
    chi2: Array,
    shape: tuple[int, int],
    invalid: NDArray[np.uint8],
    failure: NDArray[np.uint8],
) -> None:
    """Hold every method to the contract: finite, inside, with a covariance that says where."""
    for n in range(failure.size):
        if invalid[n] != _NONE:
            failure[n] = invalid[n]
        if failure[n] != _NONE:
            continue
        inside = -0.5 <= x[n] <= shape[1] - 0.5 and -0.5 <= y[n] <= shape[0] - 0.5
        if not inside:
            failure[n] = _OUTSIDE
        xx, xy, yy = covariance[n, 0, 0], covariance[n, 0, 1], covariance[n, 1, 1]
        valid = 0.0 < xx < math.inf and 0.0 < yy < math.inf and xy * xy < LEAST_ROUND * xx * yy
        for value in (amplitude[n], background[n], sigma[n], snr[n], chi2[n]):
            valid = valid and abs(value) < math.inf
        if not valid:
            failure[n] = _NOT_CONVERGED
        elif xx > EVEN * shape[1] ** 2 or yy > EVEN * shape[0] ** 2:
            failure[n] = _VAGUE
