"""Faults of a gyro's samples, and what counts in their place."""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel
import numpy as np
from numpy.typing import NDArray

# Past what a vehicle's drive, a rock under its tool or a camera drone's rotors give it.
SWIFTEST_RAD_S2 = 100.0
SHAKEN_RAD_S = 0.3  # from sample to sample: a gyro's noise and what an engine shakes it by


@kernel
def _leaps(stamps: NDArray[np.int64], samples: Array, index: int, axis: int) -> int:
    """Return whether the rate leaps up (1) or down (-1) from a sample to the next one, or 0."""
    step = samples[index + 1, axis] - samples[index, axis]
    if abs(step) <= SHAKEN_RAD_S + SWIFTEST_RAD_S2 * 1e-9 * (stamps[index + 1] - stamps[index]):
        return 0
    return 1 if step > 0.0 else -1


@kernel
def without_faults(
    stamps: NDArray[np.int64], samples: Array, rates: Array, place: int
) -> int:
    """Fill the rates about a sample that has come; return 1 where the newest one must wait."""
    last = len(stamps) - 1
    for index in range(max(place - 1, 1), min(place + 2, last)):
        for k in range(3):
            rates[index, k] = samples[index, k]
            up = _leaps(stamps, samples, index - 1, k)
            if up != 0 and _leaps(stamps, samples, index, k) == -up:
                before, after = samples[index - 1, k], samples[index + 1, k]
                rates[index, k] = max(before, after) if up > 0 else min(before, after)
    if last == 0:
        return 0
    for k in range(3):
        if _leaps(stamps, samples, last - 1, k) != 0:
            return 1
    return 0
