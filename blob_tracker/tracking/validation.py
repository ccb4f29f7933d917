"""What a stamp and a parameter must keep to."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite

from blob_tracker.tracking.errors import TrackingError

# 146 years: ROS time ends before, and differences of stamps fit 64 bits.
FARTHEST_NS = 2**62


def check_stamp(stamp_ns: int) -> None:
    """Raise TrackingError if a stamp is none of ROS time."""
    if not -FARTHEST_NS <= stamp_ns <= FARTHEST_NS:
        raise TrackingError(
            f'the stamp is {stamp_ns} ns; it must be within 146 years of 0 (is it in ns?)'
        )


def check_positive(values: Mapping[str, float], unit: str = '') -> None:
    """Raise TrackingError if one of these parameters is not above 0 and finite."""
    for name, value in values.items():
        if not (value > 0.0 and isfinite(value)):
            raise TrackingError(f'{name} is {value}{unit}; it must be above 0 and finite')


def check_limits(gate_sigma: float, coast: float, max_sigma: float) -> None:
    """Raise TrackingError if a limit of a track cannot be; a gate and coast may be infinite."""
    check_positive({'max_sigma': max_sigma})
    for name, value in (('gate_sigma', gate_sigma), ('coast', coast)):
        if not value > 0.0:
            raise TrackingError(f'{name} is {value}; it must be above 0')
