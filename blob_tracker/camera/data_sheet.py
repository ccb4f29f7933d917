"""What the data sheets of a lens and a sensor say of a bearing, and how well they know it."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan, cos, hypot, isfinite, sin, sqrt

from blob_tracker.camera.model import CameraModel
from blob_tracker.camera.yaml_file import CalibrationError
from blob_tracker.units import MRAD_PER_RAD


@dataclass(frozen=True)
class DataSheet:
    """
    A camera known by its data sheets alone.

    A tolerance is the half-width of what the maker allows; all within it are taken to be as
    likely, so its standard deviation is the tolerance over sqrt(3) (GUM, JCGM 100:2008, 4.3.7).
    The distortion, of which few data sheets speak, is not in it: a calibration is.

    Parameters
    ----------
    width, height : int
        Size of the full sensor, px.
    focal_length_mm : float
        Of the lens, mm.
    pixel_um : float
        Pitch of the square pixels, um.
    focal_length_tolerance : float
        Of the focal length, a part of it: 5 % is usual for what is engraved on a lens.
    pixel_tolerance : float
        Of the pitch, a part of it: half of the last digit in print, more or less.
    centre_tolerance_mm : float
        Of the optical axis' place on the sensor, mm: mount and sensor are seldom better centred.

    Raises
    ------
    CalibrationError
        If a length is not above 0, or a tolerance is below 0 or not finite.

    Examples
    --------
    A lens of 25 mm before pixels of 3.45 um, and how well the bearing of a light 100 mrad off its
    axis is known by that alone, mrad:

    >>> sheet = DataSheet(1280, 1024, focal_length_mm=25.0, pixel_um=3.45)
    >>> round(sheet.angle(1.0), 3)  # mrad a pixel
    0.138
    >>> round(sheet.bearing_sigma(0.0), 1), round(sheet.bearing_sigma(100.0), 1)
    (4.6, 5.4)

    """

    width: int
    height: int
    focal_length_mm: float
    pixel_um: float
    focal_length_tolerance: float = 0.05
    pixel_tolerance: float = 0.005
    centre_tolerance_mm: float = 0.2

    def __post_init__(self) -> None:
        for name in ('focal_length_tolerance', 'pixel_tolerance', 'centre_tolerance_mm'):
            value = getattr(self, name)
            if not (isfinite(value) and value >= 0.0):
                raise CalibrationError(f'{name} is {value:g}; it must be 0 or more')
        self.camera_model()

    def camera_model(self) -> CameraModel:
        """Return the ideal lens of these numbers."""
        return CameraModel.from_data_sheet(
            self.width, self.height, self.focal_length_mm, self.pixel_um
        )

    def field_of_view(self) -> tuple[float, float]:
        """
        Return the angles that are seen across the width and down the height, rad.

        2 atan(w / (2 f)) with the sensor's width, or height, w in mm (thesis, eq. 2.2).
        """
        across, down = (
            2.0 * atan(0.5e-3 * count * self.pixel_um / self.focal_length_mm)
            for count in (self.width, self.height)
        )
        return across, down

    def angle(self, pixels: float) -> float:
        """
        Return the angle to the axis of what is imaged so many px from it, mrad.

        atan(c r / f) with the pitch c and r px (thesis, eq. 2.3): with r the resolution of a
        location, the least angle that can be told apart.
        """
        return MRAD_PER_RAD * atan(1e-3 * self.pixel_um * pixels / self.focal_length_mm)

    def bearing_sigma(self, angle: float) -> float:
        """
        Return the standard deviation of a bearing that is due to the data sheets alone.

        A place u px from the axis is seen at theta = atan(u c / f), and so

            sigma^2 = (sin(2 theta) / 2)^2 (sigma_f^2 / f^2 + sigma_c^2 / c^2)
                      + (cos(theta)^2 sigma_centre / f)^2

        Parameters
        ----------
        angle : float
            Between the ray and the optical axis, mrad.

        Returns
        -------
        float
            mrad, in the plane of the ray and the axis. It is the same in every frame: the mean of
            many is no better.

        """
        theta = angle / MRAD_PER_RAD
        scale = hypot(self.focal_length_tolerance, self.pixel_tolerance)
        shift = self.centre_tolerance_mm / self.focal_length_mm
        return (
            MRAD_PER_RAD / sqrt(3.0)
            * hypot(sin(theta) * cos(theta) * scale, cos(theta) ** 2 * shift)
        )
