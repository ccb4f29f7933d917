"""Table 2.1 of the thesis: the least angle and the field of view of a lens."""

from __future__ import annotations

from decimal import Decimal, ROUND_HALF_UP

from blob_tracker.camera import DataSheet
from blob_tracker.studies.printed import load
import numpy as np

# The sensor that gives the printed table. The text has one of 7.95 x 6.45 mm (page 11).
THESIS_WIDTH, THESIS_HEIGHT, THESIS_PIXEL = 641, 489, 10.0  # px, px, um
WIDTH_IN_THE_TEXT = 7.95  # mm


def printed() -> dict[float, tuple[str, str]]:
    """Return Table 2.1 as it is printed: focal length, mm -> angle, mrad; field, degrees."""
    return {
        float(length): (angle, field) for length, angle, field in load('table_2_1').rows
    }


def computed(focal_length: float, width_mm: float | None = None) -> tuple[str, str]:
    """
    Return a row of Table 2.1: least angle at 1 px, mrad, and field of view, degrees.

    Rounded as the thesis did it, from four digits to two: its 0.63 mrad at 16 mm is
    atan(0.01 / 16) = 0.62499992 mrad.

    Parameters
    ----------
    focal_length : float
        mm.
    width_mm : float, optional
        Width of the sensor, mm, with the same number of pixels; 6.41 mm if left out.

    """
    pixel = THESIS_PIXEL if width_mm is None else 1e3 * width_mm / THESIS_WIDTH
    sheet = DataSheet(THESIS_WIDTH, THESIS_HEIGHT, focal_length, pixel)
    return (
        _rounded_twice(sheet.angle(1.0)),
        _rounded_twice(float(np.degrees(sheet.field_of_view()[0]))),
    )


def _rounded_twice(value: float) -> str:
    """Return a value with two digits, as the thesis rounded it: from four, and a half upwards."""
    return str(Decimal(f'{value:.4f}').quantize(Decimal('0.01'), ROUND_HALF_UP))
