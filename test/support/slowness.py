"""How much longer things take on this machine now than on a quiet one: time limits go by it."""

from __future__ import annotations

import os
import time

REFERENCE = 'SLOWNESS_AT_THE_START'  # environment variable: what the first process of a run found
WORK = 300_000  # sums that are timed
QUIET = 0.02  # s that they take on a quiet machine of the kind that the limits were set on


def measure_reference() -> None:
    """Time work that is always the same, for this process and those that it starts."""
    began = time.perf_counter()
    sum(number * number for number in range(WORK))
    os.environ[REFERENCE] = str((time.perf_counter() - began) / QUIET)


def slowness() -> float:
    """
    Return the factor, 1 or more, by which a time limit is to be longer.

    It is the reference run's, or what waits for each processor now where that is more: others may
    have begun since.
    """
    waiting = os.getloadavg()[0] / (os.cpu_count() or 1)
    return max(1.0, float(os.environ.get(REFERENCE, 1.0)), waiting)
