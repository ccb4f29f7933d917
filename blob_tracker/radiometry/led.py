"""The light: how much of its power goes towards the camera."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, erf, log, pi, radians, sqrt

from blob_tracker.radiometry.error import above_zero, OpticsError, parts

WIDEST_DEGREES = 89.0  # half-angle; that of a matt surface is 60


@dataclass(frozen=True)
class Led:
    """
    A light-emitting diode, by its data sheet.

    Parameters
    ----------
    power : float
        Electrical power while it is on, W.
    efficiency : float
        Part of that which leaves it as light: some 0.3 to 0.5 of red, blue and infrared ones, a
        half of that of green ones.
    half_angle : float
        Between its axis and where it is half as bright, degrees: half of the viewing angle that a
        data sheet has. 60 without a lens.
    off_axis : float
        Between its axis and the camera, degrees.
    wavelength : float
        nm.
    line_width : float
        Full width at half of the maximum of its spectrum, nm.
    diameter : float
        Of what shines, m.
    flash : float
        How long it is on, s; 0 is for as long as the exposure.

    Raises
    ------
    OpticsError
        For an impossible number.

    Examples
    --------
    A red diode of 1 W without a lens, and one with a lens of +-10 degrees:

    >>> round(Led(1.0).intensity(), 2), round(Led(1.0, half_angle=10.0).intensity(), 1)  # W/sr
    (0.11, 2.6)
    >>> round(Led(1.0, line_width=20.0).passed(10.0), 2)  # of its light, by a filter of 10 nm
    0.44

    """

    power: float
    efficiency: float = 0.35
    half_angle: float = 60.0
    off_axis: float = 0.0
    wavelength: float = 630.0
    line_width: float = 20.0
    diameter: float = 0.003
    flash: float = 0.0

    def __post_init__(self) -> None:
        above_zero({
            'the power, W,': self.power, 'the line width, nm,': self.line_width,
            'the diameter, m,': self.diameter,
        })
        parts({'the efficiency': self.efficiency})
        if not 0.0 < self.half_angle <= WIDEST_DEGREES:
            raise OpticsError(
                f'the half-angle is {self.half_angle:g} degrees; it must be above 0 and at most '
                f'{WIDEST_DEGREES:g}'
            )
        if not 0.0 <= self.off_axis < 90.0:
            raise OpticsError(
                f'the camera is {self.off_axis:g} degrees off the axis; it must be 0 to 90'
            )
        if not 400.0 <= self.wavelength <= 1000.0:
            raise OpticsError(f'the wavelength is {self.wavelength:g} nm; it must be 400 to 1000')
        if not self.flash >= 0.0:
            raise OpticsError(f'the flash lasts {self.flash:g} s; it must be 0 or more')

    def intensity(self) -> float:
        """
        Return the radiant intensity towards the camera, W/sr.

        With the power P of the light and the half-angle theta_h, a lobe of cosines (Kahn and
        Barry, Proceedings of the IEEE 85 (1997) 265, eq. 9):

            I = P (m + 1) / (2 pi) cos(theta)^m,    m = -ln 2 / ln cos(theta_h)

        A matt surface has m = 1, and P / pi on its axis.
        """
        order = -log(2.0) / log(cos(radians(self.half_angle)))
        on_axis = self.power * self.efficiency * (order + 1.0) / (2.0 * pi)
        return on_axis * cos(radians(self.off_axis)) ** order

    def passed(self, width: float) -> float:
        """
        Return the part of its light within a pass band about its wavelength.

        Of a Gaussian spectrum of the full width w at half maximum, within the width d:

            erf(sqrt(ln(2)) d / w)

        Parameters
        ----------
        width : float
            Of the pass band, nm.

        """
        return erf(sqrt(log(2.0)) * width / self.line_width)
