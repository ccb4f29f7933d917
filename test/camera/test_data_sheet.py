"""A camera known by its data sheets: its lens, and how far it can be trusted."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.camera import CalibrationError, CameraModel, DataSheet
import numpy as np
import pytest

SHEET = DataSheet(1440, 1080, focal_length_mm=8.0, pixel_um=3.45)


def test_camera_of_a_data_sheet() -> None:
    """6 mm before 10 um is the 600 px, and the field of view, that the thesis has."""
    model = CameraModel.from_data_sheet(641, 489, 6.0, 10.0)
    assert model.matrix.tolist() == [[600.0, 0.0, 320.0], [0.0, 600.0, 244.0], [0.0, 0.0, 1.0]]
    across, down = np.degrees(DataSheet(641, 489, 6.0, 10.0).field_of_view())
    assert across == pytest.approx(56.22, abs=0.005)
    edge = model.angles(-0.5, 244.0)[0]
    assert edge == pytest.approx(-1e3 * np.radians(across / 2), rel=1e-12)
    assert model.angles(320.0, -0.5)[1] == pytest.approx(1e3 * np.radians(down / 2), rel=1e-12)


def test_angle_of_a_resolution() -> None:
    """What the camera model says of a pixel so far from the axis."""
    model = SHEET.camera_model()
    assert SHEET.angle(300.0) == pytest.approx(model.angles(719.5 + 300.0, 539.5)[0], rel=1e-12)


@pytest.mark.parametrize('offset', [0.0, 200.0, 500.0, 720.0])
def test_sigma_is_the_scatter_of_cameras(offset: float) -> None:
    """Of 20000 cameras that the data sheets allow, all seeing a light on the same pixel."""
    random = np.random.default_rng(8)
    count = 20000
    focal_length = 8.0 * (1.0 + random.uniform(-0.05, 0.05, count))
    pixel = 3.45e-3 * (1.0 + random.uniform(-0.005, 0.005, count))
    centre = random.uniform(-0.2, 0.2, count)
    angles = 1e3 * np.arctan((pixel * offset - centre) / focal_length)
    # The spread of a sample of n is known to 1 / sqrt(2 n) = 0.5 %, and what the first derivative
    # leaves out at 5 % is less than that squared.
    assert SHEET.bearing_sigma(SHEET.angle(offset)) == pytest.approx(angles.std(), rel=0.02)


def test_each_tolerance_counts() -> None:
    """Scale alone leaves the axis alone; the centre alone is worst on the axis."""
    scale = replace(SHEET, centre_tolerance_mm=0.0)
    assert scale.bearing_sigma(0.0) == 0.0
    # At 45 degrees of a lens: 1/2 of 5 % over sqrt(3).
    alone = replace(scale, pixel_tolerance=0.0)
    assert alone.bearing_sigma(250.0 * np.pi) == pytest.approx(25.0 / np.sqrt(3.0))
    centre = replace(SHEET, focal_length_tolerance=0.0, pixel_tolerance=0.0)
    assert centre.bearing_sigma(0.0) == pytest.approx(25.0 / np.sqrt(3.0))  # 0.2 of 8 mm
    assert centre.bearing_sigma(300.0) < centre.bearing_sigma(0.0)


@pytest.mark.parametrize(
    'change, sentence',
    [
        ({'width': 0}, 'must be positive'),
        ({'focal_length_mm': 0.0}, 'the focal length is 0 mm; it must be above 0'),
        ({'focal_length_mm': np.inf}, 'the focal length is inf mm'),
        ({'pixel_um': -3.45}, 'the pixel size is -3.45 um'),
        ({'pixel_um': np.nan}, 'the pixel size is nan um'),
        ({'focal_length_tolerance': -0.1}, 'focal_length_tolerance is -0.1; it must be 0 or more'),
        ({'pixel_tolerance': np.nan}, 'pixel_tolerance is nan'),
        ({'centre_tolerance_mm': np.inf}, 'centre_tolerance_mm is inf'),
    ],
)
def test_impossible_numbers(change: dict, sentence: str) -> None:
    """Each has its sentence."""
    with pytest.raises(CalibrationError, match=sentence):
        replace(SHEET, **change)
