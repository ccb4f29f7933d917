"""What is said of numbers that no light, lens or weather has."""

from __future__ import annotations

from math import isfinite


class OpticsError(ValueError):
    """
    An impossible number; the message says which, and what it must be.

    Examples
    --------
    >>> from blob_tracker.radiometry import Led
    >>> Led(power=-1.0)
    Traceback (most recent call last):
        ...
    blob_tracker.radiometry.error.OpticsError: the power, W, is -1; it must be above 0

    """


def above_zero(values: dict[str, float]) -> None:
    """Raise `OpticsError` for one that is not above 0 and finite; the keys are their names."""
    for name, value in values.items():
        if not (isfinite(value) and value > 0.0):
            raise OpticsError(f'{name} is {value:g}; it must be above 0')


def parts(values: dict[str, float]) -> None:
    """Raise `OpticsError` for one that is not above 0 and at most 1; the keys are their names."""
    for name, value in values.items():
        if not 0.0 < value <= 1.0:
            raise OpticsError(f'{name} is {value:g}; it must be above 0 and at most 1')
