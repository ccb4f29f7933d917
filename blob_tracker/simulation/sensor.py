"""A sensor: mean signal in, noisy and quantised DN out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import inf, isfinite

from blob_tracker.simulation.blooming import spill
from blob_tracker.simulation.noise_bank import NoiseBank
from blob_tracker.simulation.quantisation import quantise
from blob_tracker.types import Pixels, SensorNoise
import numpy as np
from numpy.typing import NDArray

# What the analogue way does to the read-out signal of a whole frame, (h, w) DN: it may write to
# the array that it is given, and returns one of the same shape.
Stage = Callable[[NDArray[np.float32]], NDArray[np.float32]]


@dataclass(frozen=True)
class Sensor:
    """
    A sensor and what follows it, up to the numbers, in the terms of EMVA 1288.

    Light falls on pixels of a fill factor and makes charge, by PRNU not the same in each. Charge
    has shot noise; what is above the full well is drained, or blooms. The read-out adds black
    level, DSNU and read noise; stages of the analogue way come next, then gamma, and last the
    converter to n bits, which clips. Hot pixels are elements of the scene, see `HotPixels`.

    Parameters
    ----------
    noise : SensorNoise
        Gain (e-/DN, EMVA's 1 / K), read noise and black level (DN).
    bits : int
        Of the converter, 1 to 16: full scale is 2^bits - 1 DN.
    fill_factor : float
        Part of a pixel that is sensitive, a square in its middle. The signal is the mean over
        it: a smaller one sees the same level in a finer place. 0 is a point.
    row_time : float
        From the exposure of a row to that of the next, s; 0 for a global shutter.
    full_well : float
        Most charge that a pixel holds, e-.
    blooming : bool
        Whether charge above it runs along the column; else it is drained.
    prnu : float
        Standard deviation of the pixels' response over its mean (EMVA 1288: PRNU_1288).
    dsnu : float
        Standard deviation of the pixels' black levels, DN (EMVA 1288: K DSNU_1288).
    gamma : float
        Exponent from signal to number, both as parts of full scale: 1 is linear, 0.45 is that of
        a television camera.
    stages : sequence of callable
        Take the read-out signal of the whole frame, (h, w) float32 in DN, noise and black level
        included, and return it changed; in this order, before gamma and converter.
    seed : int
        Of the fixed pattern: of PRNU and DSNU.

    Raises
    ------
    ValueError
        If one of them is invalid.

    Examples
    --------
    A converter of 8 bits clips what is above its full scale:

    >>> sensor = Sensor(SensorNoise(gain=40.0, read_noise=0.7), bits=8)
    >>> sensor.expose(np.full((1, 3), 400.0), np.random.default_rng(1)).tolist()  # DN
    [[255, 255, 255]]
    >>> Sensor(bits=12).saturation
    4095

    """

    noise: SensorNoise = SensorNoise(gain=40.0, read_noise=0.7)
    bits: int = 8
    fill_factor: float = 1.0
    row_time: float = 0.0
    full_well: float = inf
    blooming: bool = False
    prnu: float = 0.0
    dsnu: float = 0.0
    gamma: float = 1.0
    stages: Sequence[Stage] = ()
    seed: int = 1

    def __post_init__(self) -> None:
        if not 1 <= self.bits <= 16:
            raise ValueError(f'{self.bits} bits; it must be 1 to 16')
        if not 0.0 <= self.fill_factor <= 1.0:
            raise ValueError(f'the fill factor is {self.fill_factor}; it must be 0 to 1')
        if not (isfinite(self.row_time) and self.row_time >= 0.0):
            raise ValueError(f'row_time is {self.row_time} s; it must be finite, 0 or more')
        if not self.full_well > 0.0:
            raise ValueError(f'the full well is {self.full_well} e-; it must be above 0')
        if isfinite(self.full_well) and not isfinite(self.noise.gain):
            raise ValueError('a full well is in electrons: with it the gain must be finite')
        if not self.gamma > 0.0:
            raise ValueError(f'gamma is {self.gamma}; it must be above 0')

    @property
    def saturation(self) -> int:
        """Full scale, DN."""
        return 2**self.bits - 1

    def expose(
        self, mean: NDArray[np.floating], random: np.random.Generator | NoiseBank
    ) -> Pixels:
        """
        Draw pixels about their mean.

        Parameters
        ----------
        mean : (..., h, w) array
            DN, the black level included.
        random : Generator or NoiseBank
            Source of the noise; the same state gives the same bits.

        Returns
        -------
        (..., h, w) array of uint8 or uint16
            DN.

        """
        signal = self.read_out(mean, random)
        for stage in self.stages:
            signal = stage(signal)
        if self.gamma != 1.0:
            np.maximum(signal, 0.0, out=signal)
            signal = self.saturation * (signal / self.saturation) ** np.float32(self.gamma)
        return quantise(signal, self.saturation)

    def read_out(
        self, mean: NDArray[np.floating], random: np.random.Generator | NoiseBank
    ) -> NDArray[np.float32]:
        """Return the signal before stages, gamma and converter, see `expose`; float32, DN."""
        if self.prnu or isfinite(self.full_well):
            signal = self._read_charge(mean, random)
        else:
            signal = _noisy(mean, self.noise, random)
        if self.dsnu:
            signal += np.float32(self.dsnu) * _fixed_pattern(mean.shape[-2:], self.seed, 1)
        return signal

    def _read_charge(
        self, mean: NDArray[np.floating], random: np.random.Generator | NoiseBank
    ) -> NDArray[np.float32]:
        """Return the signal of pixels that differ, or fill up: read noise comes after that."""
        noise = self.noise
        charge = np.subtract(mean, noise.black_level, dtype=np.float32)  # as DN
        if self.prnu:
            charge *= 1.0 + np.float32(self.prnu) * _fixed_pattern(charge.shape[-2:], self.seed, 0)
        charge += np.sqrt(np.maximum(charge, 0.0) / np.float32(noise.gain)) * (
            random.standard_normal(charge.shape, dtype=np.float32)
        )
        if isfinite(self.full_well):
            full_well = self.full_well / noise.gain
            if self.blooming:
                spill(charge, full_well)
            else:
                np.minimum(charge, full_well, out=charge)
        charge += np.float32(noise.read_noise) * (
            random.standard_normal(charge.shape, dtype=np.float32)
        )
        charge += np.float32(noise.black_level)
        return charge


def expose(
    mean: NDArray[np.floating],
    noise: SensorNoise,
    random: np.random.Generator | NoiseBank,
    *,
    saturation: int = 255,
) -> Pixels:
    """
    Draw pixels about their mean: shot noise, read noise, rounding, clipping, and nothing else.

    Shot noise is drawn as a Gaussian of the Poisson's variance, which is within a few per cent
    in every moment above about 20 electrons and several times faster.

    Parameters
    ----------
    mean : array
        DN, the black level included.
    noise : SensorNoise
        Gain in electrons per DN, read noise and black level in DN.
    random : Generator or NoiseBank
        Source of the noise; the same state gives the same bits.
    saturation : int
        Full scale, DN: 255 gives uint8, more gives uint16.

    Returns
    -------
    array of uint8 or uint16
        DN, of the shape of `mean`.

    Examples
    --------
    Of 100 DN at 40 electrons a DN, the standard deviation of a pixel, DN:

    >>> noise = SensorNoise(gain=40.0, read_noise=0.7)
    >>> pixels = expose(np.full((100, 100), 100.0), noise, np.random.default_rng(1))
    >>> pixels.dtype.name, round(float(pixels.std()), 1)
    ('uint8', 1.8)
    >>> round((100.0 / 40.0 + 0.7**2 + 1.0 / 12.0) ** 0.5, 1)
    1.8

    """
    return quantise(_noisy(mean, noise, random), saturation)


def _noisy(
    mean: NDArray[np.floating], noise: SensorNoise, random: np.random.Generator | NoiseBank
) -> NDArray[np.float32]:
    """Return the mean with shot and read noise in one draw, DN."""
    # In place: a new array of a frame's size costs more than the sums on it.
    deviation = np.maximum(mean, noise.black_level)
    deviation -= noise.black_level
    deviation /= noise.gain
    deviation += noise.read_noise**2
    np.sqrt(deviation, out=deviation)
    pixels = np.multiply(
        random.standard_normal(mean.shape, dtype=np.float32),
        deviation.astype(np.float32, copy=False),
    )
    pixels += mean.astype(np.float32, copy=False)
    return pixels


@lru_cache(maxsize=4)
def _fixed_pattern(shape: tuple[int, int], seed: int, which: int) -> NDArray[np.float32]:
    """Return normal deviates that a sensor's pixels keep: 0 is for PRNU, 1 for DSNU."""
    random = np.random.Generator(np.random.SFC64([seed, which]))
    pattern = random.standard_normal(shape, dtype=np.float32)
    pattern.flags.writeable = False
    return pattern
