"""The response of a camera whose pixels are not proportional to the light: gamma, and its like."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from blob_tracker.camera.yaml_file import CalibrationError, check_size, YamlFile
from blob_tracker.types import Frame, Window
import numpy as np
from numpy.typing import NDArray

VERSION = 1  # of the file
FINENESS = 16  # linear DN for a raw one, on the average: finer than any raw step tells apart
FULL_SCALE_DN = 65535
FEWEST, MOST = 2, 1025  # knots
LONGEST = 200  # characters of a name
OTHER_DEPTH = 2.0  # ratio of two clipping levels: limited and full range differ by less


@dataclass(frozen=True)
class Response(YamlFile):
    """
    How much light there was, in linear DN, for each raw DN.

    A camera gives d = g(e) for the light e, with g growing: a gamma curve, a knee, an S. Here is
    its inverse h(d) at knots, between which it runs as a monotone cubic (PCHIP; Fritsch and
    Carlson 1980). Linear DN are a scale of their own: h is 0 at 0 DN, and 16 times the clipping
    level there, or 65535 if that is less. A pixel of h has the noise of a linear camera,

        h'(d)^2 var(d) = (h - black_level) / gain + read_noise^2,

    and the rounding to whole raw DN adds h'(d)^2 / 12, which grows about as h does where g is a
    power of e, and so is in gain and read noise as they are measured of linear pixels.

    Parameters
    ----------
    levels : (k,) array
        Raw DN of the knots, from 0 to the level at which a pixel is clipped.
    linear : (k,) array
        Linear DN there; never falling, and 0 at the first.
    sigma : (k,) array
        Standard deviation of their errors, linear DN.
    width, height : int
        Of the camera's picture, px.
    bits : int
        Of a raw pixel's type: 8 or 16.
    camera : str
        Its name, in the user's words.
    pixel_format : str
        What it was set to, in the user's words: 'YUYV'.
    method : str
        How the response was measured.

    Raises
    ------
    CalibrationError
        If a value is invalid.

    Examples
    --------
    A camera with a gamma of 0.5: 120 of 255 raw DN are (120 / 255)^2, 22 %, of the light:

    >>> levels = np.linspace(0.0, 255.0, 18)
    >>> linear = 4080.0 * (levels / 255.0) ** 2
    >>> response = Response(levels, linear, np.zeros(18), width=640, height=480)
    >>> response.linear_pixels(np.array([[0, 120, 255]], np.uint8)).tolist()  # linear DN
    [[0, 904, 4080]]
    >>> response.saturation, response.linear_saturation(255)  # raw DN, linear DN
    (255, 4080)

    """

    KIND = 'response'

    levels: NDArray[np.float64]
    linear: NDArray[np.float64]
    sigma: NDArray[np.float64]
    width: int
    height: int
    bits: int = 8
    camera: str = ''
    pixel_format: str = ''
    method: str = ''

    def __post_init__(self) -> None:
        levels, linear = self.levels, self.linear
        if levels.ndim != 1 or not FEWEST <= levels.size <= MOST:
            raise CalibrationError(f'a response is a list of {FEWEST} to {MOST} levels')
        if linear.shape != levels.shape or self.sigma.shape != levels.shape:
            raise CalibrationError(
                f'the response has {levels.size} levels, {linear.size} linear values and '
                f'{self.sigma.size} sigmas; it needs one of each for every level'
            )
        if not all(np.isfinite(each).all() for each in (levels, linear, self.sigma)):
            raise CalibrationError('the response holds values that are not numbers')
        if self.bits not in (8, 16):
            raise CalibrationError(f'the response is for pixels of {self.bits} bits, not 8 or 16')
        if levels[0] != 0.0 or linear[0] != 0.0 or not (np.diff(levels) > 0.0).all():
            raise CalibrationError('the levels of a response must grow, and both begin at 0')
        if levels[-1] > 2**self.bits - 1 or levels[-1] != round(levels[-1]):
            raise CalibrationError(
                f'the last level of the response is {levels[-1]:g} DN, which no pixel of '
                f'{self.bits} bits is clipped at'
            )
        if not (np.diff(linear) >= 0.0).all() or not 1.0 <= linear[-1] <= FULL_SCALE_DN:
            raise CalibrationError(
                f'the linear values of a response must not fall, and end between 1 and '
                f'{FULL_SCALE_DN}'
            )
        if not (self.sigma >= 0.0).all():
            raise CalibrationError('the sigmas of a response must be 0 or more')
        if self.width < 1 or self.height < 1:
            raise CalibrationError(
                f'a picture of {self.width} x {self.height} px has no response'
            )

    @classmethod
    def _of_content(cls, content: dict[str, Any]) -> Response:
        version = int(content['version'])
        if version != VERSION:
            raise CalibrationError(
                f'it is a response of version {version}, and this program reads {VERSION}: '
                'measure it again'
            )
        levels, linear, sigma = (np.array(content[name], dtype=float) for name in _CURVES)
        camera, pixel_format, method = (str(content[name])[:LONGEST] for name in _NAMES)
        return cls(
            levels, linear, sigma, int(content['image_width']), int(content['image_height']),
            int(content['bits']), camera, pixel_format, method,
        )

    def _content(self) -> dict[str, Any]:
        return {
            'version': VERSION,
            **{name: getattr(self, name) for name in _NAMES},
            'image_width': self.width,
            'image_height': self.height,
            'bits': self.bits,
            **{name: np.round(getattr(self, name), 4).tolist() for name in _CURVES},
        }

    @property
    def saturation(self) -> int:
        """Level at which a pixel is clipped, raw DN."""
        return int(self.levels[-1])

    @cached_property
    def table(self) -> NDArray[np.uint16]:
        """
        Linear DN of each raw one.

        Returns
        -------
        (256,) or (saturation + 1,) array
            What is above the clipping level is as at it.

        """
        import scipy  # no part of a start

        size = 256 if self.bits == 8 else self.saturation + 1
        raw = np.minimum(np.arange(size), self.saturation)
        curve = scipy.interpolate.PchipInterpolator(self.levels, self.linear)
        return np.rint(curve(raw)).astype(np.uint16)

    @cached_property
    def raw_steps(self) -> NDArray[np.float64]:
        """Return the (2, n) linear DN of each raw one, and h' there: linear DN in a raw one."""
        import scipy

        curve = scipy.interpolate.PchipInterpolator(self.levels, self.linear)
        raw = np.arange(self.saturation + 1)
        return np.stack([curve(raw), curve(raw, 1)])

    def slope(self, linear: float) -> float:
        """Return h' at a level in linear DN."""
        return float(np.interp(linear, *self.raw_steps))

    @cached_property
    def _made(self) -> NDArray[np.bool_]:
        """Return whether a linear pixel can have each of 65536 DN, the last if it is clipped."""
        made = np.zeros(FULL_SCALE_DN + 1, dtype=bool)
        made[self.table] = made[FULL_SCALE_DN] = True
        return made

    def has_made(self, pixels: NDArray[Any]) -> bool:
        """
        Tell whether pixels of one frame were made linear by this response.

        Linear DN are that much finer than raw ones that most of them are those of no raw one.

        Parameters
        ----------
        pixels : array of uint8 or uint16
            DN; 65535 may be any clipped one.

        """
        return pixels.dtype == np.uint16 and bool(self._made[pixels].all())

    def linear_pixels(self, pixels: NDArray[Any]) -> NDArray[np.uint16]:
        """
        Return the linear DN of raw pixels.

        Parameters
        ----------
        pixels : array of uint8 or uint16
            DN, of the type that the response is for.

        """
        if pixels.dtype == np.uint8:
            import cv2

            return np.asarray(cv2.LUT(pixels, self.table), dtype=np.uint16)
        return np.asarray(self.table.take(pixels, mode='clip'))

    def linear_saturation(self, saturation: float) -> int:
        """Return the linear DN of a clipping level in raw DN."""
        return int(self.table[min(int(saturation), self.saturation)])

    def linear_frame(self, frame: Frame) -> Frame:
        """
        Return a frame in linear DN.

        Of colours each is made linear by itself, of Y Cb Cr the luma alone is left.

        Parameters
        ----------
        frame : Frame
            In raw DN.

        Raises
        ------
        CalibrationError
            See `check`; or the frame's pixels are sums of several samples of a mosaic.

        """
        if frame.mosaic is not None:
            raise CalibrationError(
                'the response is that of single samples, and the frame holds sums of them: set '
                'channel of the camera to auto'
            )
        self.check(frame.image.dtype.itemsize * 8, frame.saturation)
        raw, layout = frame.image, frame.layout
        if layout == 'yuv':
            raw, layout = np.ascontiguousarray(raw[..., 0]), 'grey'
        return replace(
            frame, image=self.linear_pixels(raw), layout=layout,
            saturation=self.linear_saturation(frame.saturation), raw_steps=self.raw_steps,
        )

    def linear_window(self, window: Window) -> Window:
        """
        Return a window of one look in linear DN, for `locate` and `Locator`.

        Parameters
        ----------
        window : Window
            In raw DN of uint8 or uint16: `Segmenter` cuts linear ones out of linear frames.

        Raises
        ------
        CalibrationError
            See `check`; or the window is a sum of frames, which cannot be made linear any more.

        """
        if window.looks > 1:
            raise CalibrationError(
                f'a sum of {window.looks} frames cannot be made linear: give the segmenter '
                'linear frames'
            )
        full = 2**self.bits - 1
        saturation = full if window.saturation is None else window.saturation
        self.check(window.lit.dtype.itemsize * 8, saturation)
        return replace(
            window,
            lit=self.linear_pixels(window.lit),
            unlit=None if window.unlit is None else self.linear_pixels(window.unlit),
            saturation=self.linear_saturation(saturation),
        )

    def check(self, bits: int, saturation: float) -> None:
        """
        Refuse pixels of another depth.

        Parameters
        ----------
        bits : int
            Of their type.
        saturation : float
            At which they are clipped, raw DN; full scale of the type says nothing.

        Raises
        ------
        CalibrationError
            If the response is for pixels of another type, or clipped elsewhere.

        """
        if bits != self.bits:
            raise CalibrationError(
                f'the response is for pixels of {self.bits} bits and these have {bits}; measure '
                'it with this camera and pixel format: python3 -m blob_tracker calibrate response'
            )
        if self.saturation * OTHER_DEPTH <= saturation < 2**bits - 1:
            raise CalibrationError(
                f'the response is for pixels that are clipped at {self.saturation} DN and these '
                f'are at {saturation:g} DN; measure it at this depth: '
                'python3 -m blob_tracker calibrate response'
            )

    def check_size(self, width: int, height: int) -> None:
        """Raise CalibrationError unless the sensor is of the size that was measured with."""
        check_size('response', (self.width, self.height), (width, height))


_CURVES = ('levels', 'linear', 'sigma')
_NAMES = ('camera', 'pixel_format', 'method')


def linear_full_scale(saturation: int) -> int:
    """
    Return the linear DN at which pixels are clipped whose raw ones are so at `saturation`.

    Examples
    --------
    >>> linear_full_scale(255), linear_full_scale(65535)  # of 8 and 16 bits
    (4080, 65535)

    """
    return min(FINENESS * saturation, FULL_SCALE_DN)
