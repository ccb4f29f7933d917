"""Calibrations that are of other pictures, and those that are merely unusual."""

from __future__ import annotations

from blob_tracker.camera import CalibrationError, CameraModel
import numpy as np
import pytest


def camera(
    fx: float = 600.0, fy: float = 600.0, cx: float = 325.0, cy: float = 236.0,
    distortion: tuple[float, ...] = (-0.2, 0.05, 0.0, 0.0, 0.0),
) -> CameraModel:
    """Return a camera of 640 x 480 px."""
    matrix = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
    return CameraModel(640, 480, matrix, np.array(distortion))


def test_a_usual_camera_is_not_doubted() -> None:
    """Principal points of real ones lie up to a tenth off the middle; grabbers have 1.1."""
    assert camera().doubts() == []
    assert camera(fx=690.0, cx=384.0, cy=200.0).doubts() == []


@pytest.mark.parametrize('scale', [0.25, 0.5])
def test_k_of_another_binning_is_refused(scale: float) -> None:
    """With the size that it is of: a bearing would be wrong by a multiple."""
    matrix = camera().matrix * np.array([[scale], [scale], [1.0]])
    model = CameraModel(640, 480, matrix, np.zeros(5))
    with pytest.raises(CalibrationError, match=f'middle of {640 * scale:.0f} x {480 * scale:.0f}'):
        model.doubts()


def test_k_in_units_of_the_width_is_refused() -> None:
    """As programs of photogrammetry write it."""
    with pytest.raises(CalibrationError, match='in units of the width; multiply it by 640'):
        camera(0.94, 0.94, 0.5, 0.37).doubts()


@pytest.mark.parametrize(
    ('model', 'sentence'),
    [
        (camera(cx=120.0), 'far from the middle of 640 x 480 px'),
        # A crop that begins in the corner of a sensor of twice the size, or K of that sensor.
        (camera(cx=639.5, cy=479.5), 'is K of a crop, or of pictures of another binning?'),
        (camera(fx=900.0), '1.50 times as high as wide'),
        # d(r) of these turns back at r = 0.55: 300 px of 400 to the corner.
        (camera(distortion=(-1.1, 0.0, 0.0, 0.0, 0.0)), 'no ray leads to'),
    ],
)
def test_what_is_unusual_is_said(model: CameraModel, sentence: str) -> None:
    """One sentence each, and the camera is used."""
    said, = model.doubts()
    assert sentence in said
