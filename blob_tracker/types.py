"""
The things that travel between the rooms: Frame, Window, Location, Bearing.

Pixel coordinates are those of the full, unbinned sensor: (0, 0) is the centre of its top-left
pixel, x to the right, y down. A sigma is a standard deviation.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, MISSING
from math import isfinite
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

# Raw pixels as a camera gives them, DN in uint8 or uint16.
Pixels = NDArray[np.unsignedinteger[Any]]


# By the types that they have
FULL_SCALE_DN: dict[np.dtype[Any], int] = {
    np.dtype(kind): int(np.iinfo(kind).max) for kind in (np.uint8, np.uint16)
}

Record = TypeVar('Record', bound=type)


def filled_at_once(cls: Record) -> Record:
    """
    Have a frozen dataclass put its fields into its dictionary.

    Its own `__init__` calls `object.__setattr__` for each of them, which takes twice as long; and
    a frame's worth of these classes is a good part of the time from a frame to its bearing.
    """
    own = fields(cls)
    defaults = {each.name: each.default for each in own if each.default is not MISSING}
    parameters = [
        f'{each.name}=defaults["{each.name}"]' if each.name in defaults else each.name
        for each in own
    ]
    lines = [f'here["{each.name}"] = {each.name}' for each in own]
    if hasattr(cls, '__post_init__'):
        lines.append('self.__post_init__()')
    scope: dict[str, Any] = {'defaults': defaults}
    exec(  # as dataclasses does it
        f'def __init__(self, {", ".join(parameters)}):\n here = self.__dict__\n '
        + '\n '.join(lines),
        scope,
    )
    made, its_own = scope['__init__'], vars(cls)['__init__']
    made.__annotations__, made.__qualname__ = its_own.__annotations__, its_own.__qualname__
    setattr(cls, '__init__', made)
    return cls


class LocationError(ValueError):
    """
    A window in which the blob cannot be placed; the message says why.

    Examples
    --------
    >>> from blob_tracker.location import locate
    >>> window = Window(lit=np.full((9, 9), 40, np.uint8), saturation=255)
    >>> locate(window, noise=SensorNoise(gain=40.0, read_noise=0.7))
    Traceback (most recent call last):
        ...
    blob_tracker.types.LocationError: the window is flat: all its pixels are equal

    """


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
        If one of them is invalid.

    Examples
    --------
    The variance of a pixel of 100 DN, DN^2:

    >>> noise = SensorNoise(gain=40.0, read_noise=0.7)
    >>> 100.0 / noise.gain + noise.read_noise**2 + 1.0 / 12.0  # doctest: +ELLIPSIS
    3.07...

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


# What the values of a frame's image are: (h, w) grey, or a Bayer mosaic by the colours of its
# first cell, row by row; (h, w, n) colours by their order, Y Cb Cr among them.
BAYER = ('rggb', 'grbg', 'gbrg', 'bggr')
PLANES = {'rgb': 3, 'bgr': 3, 'rgba': 4, 'bgra': 4, 'yuv': 3}


@filled_at_once
@dataclass(frozen=True)
class Mosaic:
    """
    The samples behind a colour sensor's filters, of which those of one colour count.

    Parameters
    ----------
    pixels : (h, w) uint8 or uint16 array
        DN of all samples, of even height and width.
    sites : (2, 2) bool array
        Which samples of each cell of 2 x 2 have the colour.
    saturation : int
        The DN at which a sample is clipped.

    Examples
    --------
    Of an RGGB sensor that sees a red light, one sample in four counts:

    >>> red = np.array([[True, False], [False, False]])
    >>> mosaic = Mosaic(np.zeros((480, 640), np.uint8), red, saturation=255)
    >>> np.tile(mosaic.sites, (240, 320)).mean().item()
    0.25

    """

    pixels: Pixels
    sites: NDArray[np.bool_]
    saturation: int


def field_of(y0: int, binning: tuple[int, int]) -> int | None:
    """
    Return the field that lines are of: 0 at the top, 1 at the bottom, None of a whole picture.

    A line of a field covers two of the picture, a column as many as ever (see
    `blob_tracker.capture.fields`); a camera that sums lines looks like one that has the top field
    alone.

    Parameters
    ----------
    y0 : int
        Place of the first line on the full, unbinned sensor, px.
    binning : (int, int)
        Sensor pixels per pixel along x and y.

    Examples
    --------
    A top field, a bottom field and a whole picture:

    >>> field_of(0, (1, 2)), field_of(1, (1, 2)), field_of(0, (1, 1))
    (0, 1, None)

    """
    across, down = binning
    return y0 // across % 2 if down == 2 * across else None


@filled_at_once
@dataclass(frozen=True)
class Frame:
    """
    One picture from a camera.

    Parameters
    ----------
    image : (h, w) or (h, w, n) uint8 or uint16 array
        Raw DN. It is looked at again when the next frame comes: do not refill it.
    stamp_ns : int
        Middle of the exposure of the image's first line, ns of ROS time.
    saturation : int
        The DN at which a pixel is clipped.
    x0, y0 : int
        Place of the image's first pixel on the full, unbinned sensor (hardware crop), px.
    binning : (int, int)
        Sensor pixels per image pixel along x and y.
    layout : str
        'grey', one of `BAYER` or one of `PLANES`.
    channel : str
        The colour of a grey image that was made of colours; '' of a grey camera.
    mosaic : Mosaic or None
        The samples of which a grey image is the sum, cell by cell.
    quantisation : (8, 8) array or None
        Steps in which a JPEG keeps the luma's cosine coefficients, DN, by row and column; None
        of a picture that was not compressed. Of the raw pixels, also where they were made linear.
    raw_steps : (2, n) array or None
        Of pixels that were made linear: levels, and how much of them a raw DN is there, DN.
    exposure_ns : int
        How long it was exposed, ns; 0 where that is not known.
    line_time_ns : float
        From the exposure of a line of the image to that of the next, ns: line r was exposed
        about stamp_ns + r line_time_ns. 0 of a global shutter, below 0 of an image whose last
        line is read first.

    Examples
    --------
    >>> frame = Frame(np.zeros((480, 640), np.uint8), stamp_ns=0, saturation=255)
    >>> frame.image.shape, frame.field is None
    ((480, 640), True)

    """

    image: Pixels
    stamp_ns: int
    saturation: int
    x0: int = 0
    y0: int = 0
    binning: tuple[int, int] = (1, 1)
    layout: str = 'grey'
    channel: str = ''
    mosaic: Mosaic | None = None
    quantisation: NDArray[np.generic] | None = None
    raw_steps: NDArray[np.float64] | None = None
    exposure_ns: int = 0
    line_time_ns: float = 0.0

    def __post_init__(self) -> None:
        planes = PLANES.get(self.layout)
        if planes is None and self.layout not in ('grey', *BAYER):
            raise ValueError(f'the layout of a frame is {self.layout!r}')
        wanted = '(h, w)' if planes is None else f'(h, w, {planes})'
        shape = self.image.shape
        if len(shape) != (2 if planes is None else 3) or shape[2:] != (
            () if planes is None else (planes,)
        ) or self.image.size == 0:
            raise ValueError(f'a frame is a non-empty {wanted} array, not {shape}')
        if self.image.dtype not in FULL_SCALE_DN:
            raise ValueError(f'a frame holds uint8 or uint16 DN, not {self.image.dtype}')
        if not isfinite(self.line_time_ns):
            raise ValueError(f'line_time_ns is {self.line_time_ns} ns; it must be finite')

    @property
    def field(self) -> int | None:
        """Return which field of an interlaced picture it is, see `field_of`."""
        return field_of(self.y0, self.binning)

    @property
    def samples(self) -> Pixels:
        """Return the pixels that the sensor gave: those of the mosaic where there is one."""
        return self.image if self.mosaic is None else self.mosaic.pixels

    @property
    def sample_saturation(self) -> int:
        """Return the DN at which one of `samples` is clipped."""
        return self.saturation if self.mosaic is None else self.mosaic.saturation


@filled_at_once
@dataclass(frozen=True)
class Glimpse:
    """
    What is known beforehand of how a light that blinks and moves was seen.

    Parameters
    ----------
    share : float
        Part of the exposure for which it was on.
    way : (2,) array
        Its displacement meanwhile, px.
    way_sigma : float
        Standard deviation of that along either axis, px.
    doubt : (2, 2) array
        Covariance that the doubt about the stamp, about its path and about lights beside it adds
        to its place, px^2.
    lag : (2,) array
        By which the middle of its light lies off its place at the stamp, as its path bends, px.
    drawn : float
        By which it lies below its place as it was switched while its lines were exposed, and the
        later ones have seen it longer, px.

    Examples
    --------
    A light that was on for half of the exposure, in which it went 3 px to the right:

    >>> glimpse = Glimpse(0.5, np.array([3.0, 0.0]), 0.1, np.zeros((2, 2)), np.zeros(2))
    >>> glimpse.numbers.shape
    (10,)
    >>> Glimpse.of_numbers(glimpse.numbers).way.tolist()  # px
    [3.0, 0.0]

    """

    share: float
    way: NDArray[np.float64]
    way_sigma: float
    doubt: NDArray[np.float64]
    lag: NDArray[np.float64]
    drawn: float = 0.0

    @property
    def numbers(self) -> NDArray[np.float32]:
        """(10,) array: share, way, way_sigma, doubt as xx, xy, yy, lag, and drawn."""
        xx, xy, _, yy = self.doubt.ravel().tolist()
        return np.array([
            self.share, *self.way.tolist(), self.way_sigma, xx, xy, yy, *self.lag.tolist(),
            self.drawn,
        ], dtype=np.float32)

    @classmethod
    def of_numbers(cls, numbers: NDArray[np.float32]) -> Glimpse:
        """Return what `numbers` tells of."""
        share, way_x, way_y, way_sigma, xx, xy, yy, lag_x, lag_y, drawn = numbers.tolist()
        return cls(
            share, np.array([way_x, way_y]), way_sigma, np.array([[xx, xy], [xy, yy]]),
            np.array([lag_x, lag_y]), drawn,
        )


@filled_at_once
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
        DN with the light off, or None if there is no such frame.
    x0, y0 : int
        Place of the window's first pixel on the full, unbinned sensor, px.
    stamp_ns : int
        When the light was seen, ns of ROS time: the middle of the exposure of the window's middle
        line, or of the part of it for which the light was on.
    saturation : int or None
        The DN at which a pixel is clipped; None if no pixel can be.
    binning : (int, int)
        Sensor pixels per window pixel along x and y.
    looks : int
        Frames that are summed in `lit`, and as many in `unlit`; 1 or more. The pixels are their
        sum, not their mean, and their read noise that of so many frames.
    sites : (h, w) bool array or None
        Which pixels see the light, behind the colour filters of a mosaic; None if all do.
    added_noise : float
        Standard deviation that compression adds to a pixel of one frame, DN.
    glimpse : Glimpse or None
        How a light that blinks was seen, where that is known.
    line_time_ns : float
        From the exposure of a line of the window to that of the next, ns; see `Frame`.

    Examples
    --------
    >>> window = Window(lit=np.full((9, 9), 60, np.uint8), x0=312, y0=240, saturation=255)
    >>> window.unlit is None, window.looks
    (True, 1)

    """

    lit: NDArray[np.generic]
    unlit: NDArray[np.generic] | None = None
    x0: int = 0
    y0: int = 0
    stamp_ns: int = 0
    saturation: float | None = None
    binning: tuple[int, int] = (1, 1)
    looks: int = 1
    sites: NDArray[np.bool_] | None = None
    added_noise: float = 0.0
    glimpse: Glimpse | None = None
    line_time_ns: float = 0.0

    def __post_init__(self) -> None:
        if self.looks < 1:
            raise ValueError(f'a window is the sum of {self.looks} frames; it must be 1 or more')

    @property
    def field(self) -> int | None:
        """Return of which field of an interlaced picture it is a part, see `field_of`."""
        return field_of(self.y0, self.binning)

    def to_window(self, x: float, y: float) -> tuple[float, float]:
        """Return a position on the full, unbinned sensor, px, as one in the window's pixels."""
        across, down = self.binning
        return (x - self.x0 + 0.5) / across - 0.5, (y - self.y0 + 0.5) / down - 0.5


@filled_at_once
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
        When the light was seen there, ns of ROS time: the window's stamp, and the time from its
        middle line to that of the place.
    warning : str
        What is not as it should be, and what to do about it; '' where all is well.

    Examples
    --------
    The standard deviations of x and y, px:

    >>> location = Location(
    ...     320.25, 240.5, np.diag([1e-4, 4e-4]), amplitude=150.0, background=40.0, sigma=2.0,
    ...     snr=50.0, chi2=1.0, saturated=0,
    ... )
    >>> [round(float(sigma), 4) for sigma in np.sqrt(location.covariance.diagonal())]
    [0.01, 0.02]

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


@filled_at_once
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
        The location's stamp, ns of ROS time.

    Examples
    --------
    To the right of the axis and below it; the standard deviation of the azimuth, mrad:

    >>> bearing = Bearing(222.6, -265.5, np.diag([4e-4, 4e-4]))
    >>> round(float(bearing.covariance[0, 0] ** 0.5), 4)
    0.02

    """

    azimuth: float
    elevation: float
    covariance: NDArray[np.float64]
    stamp_ns: int = 0
