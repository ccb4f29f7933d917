"""
Frames of a rolling shutter in a light that flickers -> the time from line to line.

A lamp of the frequency f is brighter and darker while the lines are exposed one after the other:
the picture has bands, whose spacing is 1 / (f line_time) lines. They move from frame to frame,
which tells them from the scene: each line's mean is taken over its own mean of all frames.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

Array = NDArray[np.float64]

MAINS = (100.0, 120.0)  # Hz: twice the frequency of the mains
FEWEST = 4  # frames: so many tell the scatter
FINE = 4  # spatial frequencies that are tried to one band more in the picture
HARMONICS = 4  # of the bands that are fitted: a PWM is no sinusoid
LEAST_BANDS = 1.0  # in the picture: of less the spacing is not to be told from a shade
CLEAR = 6.0  # times the usual power of a spatial frequency: noise alone reaches 3 in 4 frames
RIVAL = 0.5  # of the power of the bands, at half or twice their spacing: which is f's?
# Of a band, by which it may be elsewhere than stamps and frequency tell: what stamps are off by on
# the mean of the frames, and per period of the light, as a frequency may be off by 0.3 %
STAMPS_OFF, PERIOD_OFF = 0.03, 0.003
TOO_FAR = 0.15  # of a band: what may be off by so much tells neither frequency nor direction
# Least length of the mean of unit vectors along phases: of less the stamps jitter too much to
# tell of a frequency, or to contradict one that is given
STEADY, SURE = 0.6, 0.9


class LineTimeError(ValueError):
    """
    Frames that do not tell the line time; the message says why, and what would help.

    Examples
    --------
    A wall in the light of the sun:

    >>> frames = [(index / 30.0, np.full((480, 64), 80, np.uint8)) for index in range(20)]
    >>> measure_line_time(frames, 100.0)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    blob_tracker.calibration.line_time.LineTimeError: no bands move through the picture: ...

    """


@dataclass(frozen=True)
class LineTimeMeasurement:
    """
    How long a line takes.

    Parameters
    ----------
    line_time, sigma : float
        From the exposure of a line to that of the next, and its standard deviation, s; below 0
        where the last line is exposed first.
    frequency : float
        Of the light, Hz.
    spacing : float
        Of the bands, lines.
    bands : float
        In the height of the picture.
    contrast : float
        Amplitude of the bands over the mean.
    directed : bool
        Whether the stamps tell which line is exposed first; else it is taken to be the upper one.
    profiles : (n, h) array
        Mean of each line over its mean of all frames, less 1.
    fitted : (n, h) array
        The bands in it.

    Examples
    --------
    The read-out of a picture of 480 lines, ms:

    >>> found = LineTimeMeasurement(
    ...     line_time=30e-6, sigma=20e-9, frequency=100.0, spacing=333.3, bands=1.44, contrast=0.2,
    ...     directed=True, profiles=np.zeros((20, 480)), fitted=np.zeros((20, 480)),
    ... )
    >>> round(1e3 * 480 * found.line_time, 1)
    14.4

    """

    line_time: float
    sigma: float
    frequency: float
    spacing: float
    bands: float
    contrast: float
    directed: bool
    profiles: Array
    fitted: Array


def measure_line_time(
    frames: Iterable[tuple[float | None, Pixels]], frequency: float | None = None
) -> LineTimeMeasurement:
    """
    Measure the line time from the bands of a lamp.

    The bands are a sinusoid of one spacing and a phase of its own in each frame. The spatial
    frequency nu (cycles a line) is that with the least squares over all frames, its standard
    deviation that of the jackknife over the frames, and line_time = nu / f. From frame to frame
    the bands move by f (t_2 - t_1) of their spacing, up or down by the direction of the readout:
    where the stamps are known they tell it, and whether the frequency can be true.

    Parameters
    ----------
    frames : iterable of (float or None, (h, w) array)
        Times of the frames, s, or None if nobody knows; DN.
    frequency : float or None
        Of the light, Hz: twice that of the mains, or that of a PWM. None tries the mains of 50 and
        of 60 Hz, which takes times.

    Raises
    ------
    LineTimeError
        If there are no bands, fewer than one, or the frequency is ambiguous.

    Examples
    --------
    A lamp that flickers at 100 Hz before a rolling shutter of 30 us a line:

    >>> random, lines, frames = np.random.default_rng(1), np.arange(480)[:, None], []
    >>> for index in range(20):
    ...     light = 1.0 + 0.2 * np.cos(2.0 * np.pi * 100.0 * (index / 29.97 + 30e-6 * lines))
    ...     pixels = random.normal(80.0 * light, 2.0, (480, 16)).round().astype(np.uint8)
    ...     frames.append((index / 29.97, pixels))
    >>> found = measure_line_time(frames, 100.0)
    >>> round(1e6 * found.line_time, 1), found.directed  # us
    (30.0, True)

    """
    times, profiles = _profiles(frames)
    height = profiles.shape[1]
    tried = np.arange(0.5 / height, 0.5, 1.0 / (FINE * height))
    power = np.array([_power(profiles, each) for each in tried])
    best = int(np.argmax(power))
    if not power[best] > CLEAR * np.median(power):
        raise LineTimeError(
            'no bands move through the picture: the shutter is a global one (line_time is 0), the '
            'light does not flicker, the exposure is a whole number of its periods (shorten it), '
            'or they stand still (change frame_rate by a percent)'
        )
    wave = _refined(profiles, tried[best])
    if wave * height < LEAST_BANDS:
        raise LineTimeError(
            f'the picture shows {wave * height:.2f} bands; there must be one or more: take a '
            'light of a higher frequency, such as an LED with PWM, or more lines'
        )
    _check_rivals(profiles, wave, tried[best])
    chosen, direction = _frequency(times, _phases(profiles, wave), frequency)
    fitted, amplitude = _bands(profiles, wave)
    return LineTimeMeasurement(
        line_time=(direction or 1) * wave / chosen,
        sigma=_jackknife(profiles, wave) / chosen,
        frequency=chosen,
        spacing=1.0 / wave,
        bands=wave * height,
        contrast=amplitude,
        directed=direction != 0,
        profiles=profiles,
        fitted=fitted,
    )


def _profiles(
    frames: Iterable[tuple[float | None, Pixels]]
) -> tuple[list[float | None], Array]:
    """Return the times and what flickers in the lines."""
    times: list[float | None] = []
    means: list[Array] = []
    for time, pixels in frames:
        if means and pixels.shape[0] != means[0].size:
            raise LineTimeError(
                f'a frame has {pixels.shape[0]} lines and the first {means[0].size}; give those '
                'of one size'
            )
        times.append(time)
        means.append(pixels.mean(axis=1, dtype=float))
    if len(means) < FEWEST:
        raise LineTimeError(f'{len(means)} frames; there must be {FEWEST} or more')
    lines = np.array(means)
    usual = lines.mean(axis=0)
    if not usual.min() > 0.0:
        raise LineTimeError('a line is black in all frames: light up a wall that fills them')
    return times, lines / usual - 1.0


def _waves(height: int, wave: float, orders: int = 1) -> Array:
    """Return the (h, 2 + 2 orders) columns: a level, a slope, and a sinusoid of each order."""
    lines = np.arange(height) - 0.5 * (height - 1)
    angles = 2.0 * np.pi * wave * lines
    columns = [np.ones(height), lines / height]
    for order in range(1, orders + 1):
        columns += [np.cos(order * angles), np.sin(order * angles)]
    return np.column_stack(columns)


def _coefficients(profiles: Array, wave: float, orders: int = 1) -> tuple[Array, Array]:
    """Return the columns and what each frame has of them, (columns, n)."""
    columns = _waves(profiles.shape[1], wave, orders)
    return columns, np.asarray(np.linalg.lstsq(columns, profiles.T, rcond=None)[0])


def _power(profiles: Array, wave: float) -> float:
    """Return what squares the bands of a spatial frequency explain, beyond level and slope."""
    columns = np.linalg.qr(_waves(profiles.shape[1], wave))[0][:, 2:]
    return float(((profiles @ columns) ** 2).sum())


def _check_rivals(profiles: Array, wave: float, begun: float) -> None:
    """Refuse bands of two spacings, of which one is half the other, when both are strong."""
    height, power = profiles.shape[1], _power(profiles, wave)
    if abs(wave - begun) > 0.95 / (FINE * height):
        raise LineTimeError(
            f'the bands, some {1.0 / begun:.0f} lines apart, are not of one spacing: keep '
            'everything still, and have one light alone'
        )
    for factor in (0.5, 2.0):
        other = factor * wave
        if 1.0 / height <= other < 0.5 and _power(profiles, other) > RIVAL * power:
            raise LineTimeError(
                f'there are bands {1.0 / wave:.1f} and {1.0 / other:.1f} lines apart, and the '
                'frequency may be that of either: take one light alone, or a PWM nearer to half '
                'on and half off'
            )


def _refined(profiles: Array, wave: float) -> float:
    """Return the spatial frequency with the least squares, its harmonics beside it."""
    height = profiles.shape[1]
    orders = max(min(HARMONICS, int(0.45 / wave)), 1)

    def rest(tried: float) -> float:
        columns, found = _coefficients(profiles, tried, orders)
        return float(((profiles.T - columns @ found) ** 2).sum())

    reach = 1.0 / (FINE * height)
    return float(minimize_scalar(
        rest, bounds=(max(wave - reach, 0.25 / height), wave + reach), method='bounded',
        options={'xatol': 1e-9},
    ).x)


def _jackknife(profiles: Array, wave: float) -> float:
    """Return the standard deviation of the spatial frequency, by leaving out a part at a time."""
    count = min(len(profiles), 16)
    parts = np.arange(len(profiles)) % count
    found = np.array([_refined(profiles[parts != part], wave) for part in range(count)])
    return float(np.sqrt((count - 1) * np.var(found)))


def _phases(profiles: Array, wave: float) -> Array:
    """Return where in their period the bands begin in each frame, from 0 to 1."""
    _, found = _coefficients(profiles, wave)
    # At the first line, where the stamp is.
    return (np.arctan2(-found[3], found[2]) / (2.0 * np.pi)
            - wave * 0.5 * (profiles.shape[1] - 1)) % 1.0


def _bands(profiles: Array, wave: float) -> tuple[Array, float]:
    """Return the bands alone, and their amplitude."""
    columns, found = _coefficients(profiles, wave)
    amplitude = float(np.sqrt((found[2:] ** 2).sum(axis=0).mean()))
    return np.asarray((columns[:, 2:] @ found[2:]).T), amplitude


def _frequency(
    times: Sequence[float | None], phases: Array, given: float | None
) -> tuple[float, int]:
    """Return the frequency and the direction in which the lines are read, 0 if it is unknown."""
    known = [time for time in times if time is not None]
    if len(known) < len(times):
        if given is None:
            raise LineTimeError(
                'the frequency is ambiguous: the images have no stamps, so give --frequency: 100 '
                'for a lamp on mains of 50 Hz, 120 on 60 Hz, or that of a PWM'
            )
        return given, 0
    intervals = np.diff(np.array(known))
    fits = {
        (tried, direction): _apart(
            phases, direction * tried * intervals, STEADY if given is None else SURE
        )
        for tried in (MAINS if given is None else (given,)) for direction in (1, -1)
    }
    off = STAMPS_OFF + PERIOD_OFF * max(key[0] for key in fits) * float(np.median(intervals))
    if given is not None and (off > TOO_FAR or min(fits.values()) == np.inf):
        return given, 0
    possible = [key for key, apart in fits.items() if apart < off]
    if not possible:
        tried = 'the mains' if given is None else f'{given:g} Hz'
        raise LineTimeError(
            f'by the stamps the bands do not move as those of a lamp of {tried} would: give the '
            'true --frequency of the light'
        )
    if len({frequency for frequency, _ in possible}) > 1:
        raise LineTimeError(
            'the frequency is ambiguous: at this frame rate lamps of 100 and of 120 Hz move the '
            'bands alike; give --frequency'
        )
    frequency, direction = possible[0]
    return frequency, direction if len(possible) == 1 else 0


def _apart(phases: Array, expected: Array, least: float) -> float:
    """Return by how much of a band they moved otherwise than expected; infinite if at random."""
    mean = np.exp(2j * np.pi * (np.diff(phases) - expected)).mean()
    return float(abs(np.angle(mean)) / (2.0 * np.pi)) if abs(mean) > least else np.inf
