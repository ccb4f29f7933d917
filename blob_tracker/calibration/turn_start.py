"""Stations of a servo: what no camera can come of, and what a fit begins with."""

from __future__ import annotations

from blob_tracker.camera import CameraModel
from blob_tracker.units import MRAD_PER_RAD
import numpy as np
from numpy.typing import NDArray

LEAST_PLACES = 3  # along an axis: two give a slope, and no principal point
WIDEST, NARROWEST = 0.3, 60.0  # focal lengths in widths of the picture: 120 and 1 degrees across
NAMES = (
    'fx', 'fy', 'cx', 'cy', 'k1', 'azimuth', 'elevation', 'yaw', 'pitch', 'roll',
)  # px, px, px, px, -, and rad


class TurnError(ValueError):
    """Measurements that give no camera; the message says what is missing."""


def check_stations(
    pan: NDArray[np.float64],
    tilt: NDArray[np.float64],
    pixels: NDArray[np.float64],
    pixel_sigma: NDArray[np.float64] | None,
    step_sigma: float,
    guess: CameraModel,
) -> None:
    """Raise where no camera can come of it."""
    if pan.ndim != 1 or tilt.shape != pan.shape or pixels.shape != (len(pan), 2):
        raise TurnError(
            f'{pan.shape} pan and {tilt.shape} tilt angles do not go with {pixels.shape} pixels'
        )
    if not all(np.isfinite(values).all() for values in (pan, tilt, pixels)):
        raise TurnError('an angle or a pixel is NaN or infinite')
    if pixel_sigma is not None and not (
        np.shape(pixel_sigma) == pixels.shape
        and np.isfinite(pixel_sigma).all()
        and (np.asarray(pixel_sigma) > 0.0).all()
    ):
        raise TurnError('the sigmas of the pixels must be finite and above 0, one for each')
    if not 0.0 <= step_sigma < 1.0:
        raise TurnError(f'the sigma of the servo is {step_sigma} rad; it must be 0 to 1')
    places = max(len(np.unique(np.round(values, 6))) for values in (pan, tilt))
    if places < LEAST_PLACES:
        raise TurnError(
            f'the servo stood at {places} different angles of an axis; {LEAST_PLACES} or more '
            'are needed, and five by five over the whole picture are good'
        )
    outside = (pixels < -0.5).any(axis=1) | (
        pixels > np.array([guess.width, guess.height]) - 0.5
    ).any(axis=1)
    if outside.any():
        x, y = pixels[outside.argmax()]
        raise TurnError(
            f'the pixel ({x:.1f}, {y:.1f}) is outside of the {guess.width} x {guess.height} '
            'picture; is that the size of the camera?'
        )


def first_look(
    pan: NDArray[np.float64],
    tilt: NDArray[np.float64],
    pixels: NDArray[np.float64],
    guess: CameraModel,
    turned: tuple[bool, bool],
) -> tuple[int, int, float]:
    """Return the signs of both axes and the focal length, px, by a linear fit of the pixels."""
    if not any(turned):
        raise TurnError(
            f'pan turned by {MRAD_PER_RAD * np.ptp(pan):.2g} mrad in all and tilt by '
            f'{MRAD_PER_RAD * np.ptp(tilt):.2g}: too little. Is the unit right? The column says '
            'it: pan_mrad, pan_deg or pan_rad'
        )
    columns = [np.ones_like(pan)]
    columns += [angle - angle.mean() for angle, moved in zip((pan, tilt), turned) if moved]
    design = np.stack(columns, axis=1)
    if np.linalg.matrix_rank(design / np.linalg.norm(design, axis=0), tol=1e-3) < len(columns):
        raise TurnError(
            'pan and tilt were always turned together: turn each while the other stands still'
        )
    slopes = np.linalg.lstsq(design, pixels, rcond=None)[0][1:]
    axes = [axis for axis, moved in enumerate(turned) if moved]
    own = np.array([slope[axis] for slope, axis in zip(slopes, axes)])
    other = np.array([slope[1 - axis] for slope, axis in zip(slopes, axes)])
    if (np.abs(other) >= np.abs(own)).any():
        raise TurnError(
            'the target moves across the turn of the servo: x must follow pan and y tilt; is the '
            'camera mounted on its side, or are the columns mixed up?'
        )
    signs = {axis: int(-np.sign(value)) for axis, value in zip(axes, own)}
    focal = float(np.abs(own).mean())
    if not WIDEST < focal / guess.width < NARROWEST:
        unit = 'degrees' if focal > guess.width else 'mrad'
        raise TurnError(
            f'the target moves by {focal:.4g} px per radian, {focal / guess.width:.2g} times the '
            f"width of the picture: no lens does. Are the angles in {unit}? The column's name "
            'says the unit: pan_mrad, pan_deg or pan_rad'
        )
    return signs.get(0, 1), -signs.get(1, -1), focal


def start_values(
    pan: NDArray[np.float64],
    tilt: NDArray[np.float64],
    pixels: NDArray[np.float64],
    guess: CameraModel,
    focal: float,
) -> dict[str, float]:
    """Return the parameters that the fit starts from."""
    centre = guess.matrix[:2, 2]
    away = (pixels.mean(axis=0) - centre) / focal
    return dict(zip(NAMES, (
        focal, focal, float(centre[0]), float(centre[1]),
        float(guess.distortion[0]) if len(guess.distortion) else 0.0,
        float(pan.mean() + away[0]), float(tilt.mean() - away[1]), 0.0, 0.0, 0.0,
    )))
