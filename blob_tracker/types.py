"""
The things that travel between the rooms: Frame, Window, Location, Bearing.

Pixel coordinates are those of the full, unbinned sensor: (0, 0) is the centre of its top-left
pixel, x to the right, y down. A sigma is a standard deviation.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

# Raw pixels as a camera gives them, DN in uint8 or uint16.
Pixels = NDArray[np.unsignedinteger[Any]]


class LocationError(ValueError):
    """A window in which the blob cannot be placed; the message says why."""


@dataclass(frozen=True)
class SensorNoise:
    """
    Noise of one pixel: shot noise, read noise and quantisation.

    A pixel whose mean is m DN has the variance

        max(m - black_level, 0) / gain + read_noise^2 + 1/12    DN^2

    (EMVA 1288, eq. 12 and 15, with its 1 / K written as `gain` and its mu_y.dark as
    `black_level`).

    Parameters
    ----------
    gain : float
        Electrons per DN, above zero. Infinity switches shot noise off.
    read_noise : float
        Standard deviation of the signal-free pixel before quantisation, DN.
    black_level : float
        Mean of a pixel without light, DN.

    Raises
    ------
    ValueError
        Where one of them cannot be.

    """

    gain: float
    read_noise: float
    black_level: float = 0.0

    def __post_init__(self) -> None:
        if not self.gain > 0.0:
            raise ValueError(f'gain is {self.gain} electrons per DN; it must be above 0')
        if not (isfinite(self.read_noise) and self.read_noise >= 0.0):
            raise ValueError(f'read_noise is {self.read_noise} DN; it must be finite, 0 or more')
        if not isfinite(self.black_level):
            raise ValueError(f'black_level is {self.black_level} DN; it must be finite')


@dataclass(frozen=True)
class Frame:
    """
    One picture from a camera.

    Parameters
    ----------
    image : (h, w) uint8 or uint16 array
        Raw DN. It is looked at again when the next frame comes: do not refill it.
    stamp_ns : int
        Time of the exposure, ns of ROS time.
    saturation : int
        The DN at which a pixel is clipped.
    x0, y0 : int
        Place of the image's first pixel on the full, unbinned sensor (hardware crop), px.
    binning : (int, int)
        Sensor pixels per image pixel along x and y.

    """

    image: Pixels
    stamp_ns: int
    saturation: int
    x0: int = 0
    y0: int = 0
    binning: tuple[int, int] = (1, 1)

    def __post_init__(self) -> None:
        if self.image.ndim != 2 or self.image.size == 0:
            raise ValueError(f'a frame is a non-empty (h, w) array, not {self.image.shape}')
        if self.image.dtype not in (np.uint8, np.uint16):
            raise ValueError(f'a frame holds uint8 or uint16 DN, not {self.image.dtype}')


@dataclass(frozen=True)
class Window:
    """
    The part of a flash pair that holds the target, raw: nothing subtracted.

    The pixels are not looked at here; `locate` checks them and says what is wrong.

    Parameters
    ----------
    lit : (h, w) array
        DN with the light on.
    unlit : (h, w) array or None
        DN with the light off, or None where there is no such frame.
    x0, y0 : int
        Place of the window's first pixel on the full, unbinned sensor, px.
    stamp_ns : int
        Middle of the lit frame's exposure, ns of ROS time.
    saturation : int or None
        The DN at which a pixel is clipped; None where no pixel can be.
    binning : (int, int)
        Sensor pixels per window pixel along x and y.
    looks : int
        Frames that are summed in `lit`, and as many in `unlit`; 1 or more. The pixels are their
        sum, not their mean, and their read noise that of so many frames.

    """

    lit: NDArray[np.generic]
    unlit: NDArray[np.generic] | None = None
    x0: int = 0
    y0: int = 0
    stamp_ns: int = 0
    saturation: float | None = None
    binning: tuple[int, int] = (1, 1)
    looks: int = 1

    def __post_init__(self) -> None:
        if self.looks < 1:
            raise ValueError(f'a window is the sum of {self.looks} frames; it must be 1 or more')


@dataclass(frozen=True)
class Location:
    """
    The target's place in the picture.

    Parameters
    ----------
    x, y : float
        px, full unbinned sensor.
    covariance : (2, 2) array
        px^2, order x, y.
    amplitude, background : float
        Peak above the background and background of the fitted pulse, DN.
    sigma : float
        Standard deviation of the pulse, image px (geometric mean of the axes if elliptical).
    snr : float
        Amplitude over the standard deviation of the pixel at the peak.
    chi2 : float
        Squared residuals over their variance, per degree of freedom.
    saturated : int
        Count of clipped pixels in the window.
    stamp_ns : int
        The window's stamp, ns of ROS time.
    warning : str
        What is not as it should be, and what to do about it; '' where all is well.

    """

    x: float
    y: float
    covariance: NDArray[np.float64]
    amplitude: float
    background: float
    sigma: float
    snr: float
    chi2: float
    saturated: int
    stamp_ns: int = 0
    warning: str = ''


@dataclass(frozen=True)
class Bearing:
    """
    The direction of the target in the camera's optical frame (x right, y down, z forward).

    Parameters
    ----------
    azimuth : float
        atan2(X, Z), mrad, positive to the right.
    elevation : float
        atan2(-Y, hypot(X, Z)), mrad, positive up.
    covariance : (2, 2) array
        mrad^2, order azimuth, elevation.
    stamp_ns : int
        Middle of the lit frame's exposure, ns of ROS time.

    """

    azimuth: float
    elevation: float
    covariance: NDArray[np.float64]
    stamp_ns: int = 0
