"""Points of many frames -> the lights among them that blink, and how."""

from __future__ import annotations

from dataclasses import dataclass
import math

from blob_tracker.blinking.paths import Path, PathLinker
from blob_tracker.blinking.patterns import MAINS_HZ
from blob_tracker.blinking.recognition import (
    aliases, Brightness, DARK, EVEN, recognise, Rhythm,
)
from blob_tracker.blinking.tracker import MOST_POINTS
from blob_tracker.blinking.tracks import FLUX
from blob_tracker.kernel import Array
import numpy as np
from numpy.typing import NDArray

FEWEST_POINTS = 6  # of a light
UNKNOWN = ('short', 'irregular')
FEWEST_OF_UNKNOWN = 0.2  # of the frames, in which what keeps no rate is seen
MOST_LIGHTS = 16  # that are looked at
JITTER = 0.1  # of the frame interval, from which on the stamps are believed, not the count
MAINS_OFF_HZ = 0.3  # by which lamps are off 100 and 120 Hz, and frame rates off theirs
HIGHEST_HZ = 250.0  # of the aliases that are thought of
SAME_PERIOD = 0.01  # by which two pieces of one light differ
NEAR_HALF = 0.01  # by which a clock is off half the frame rate, where alternate follows it
SURE_CLOCK = 1e-3  # of the bit rate: clocks that run free are off by as much, or drift


@dataclass(frozen=True)
class Light:
    """
    A light that blinks.

    Parameters
    ----------
    path : Path
        Where it was.
    brightness : Brightness
        From its first frame to its last.
    rhythm : Rhythm
        How it blinks, frame intervals.
    rate : float
        Frames in a second.
    aliases : tuple of float
        Frequencies that the frames cannot tell from that of the wave, Hz.
    mains : float
        Of the lamps that it looks like, 100 or 120 Hz; 0 where it looks like none.

    """

    path: Path
    brightness: Brightness
    rhythm: Rhythm
    rate: float
    aliases: tuple[float, ...] = ()
    mains: float = 0.0

    @property
    def frequency(self) -> float:
        """Return how often its pattern repeats, Hz; 0 where it does not."""
        return self.rate / self.rhythm.period if self.rhythm.period else 0.0

    @property
    def frequency_sigma(self) -> float:
        """Return its standard deviation, Hz."""
        period = self.rhythm.period
        return self.frequency * self.rhythm.period_sigma / period if period else 0.0

    @property
    def bits_per_second(self) -> float:
        """Return the bits of a code in a second; 0 of a wave."""
        return self.rate / self.rhythm.bit if self.rhythm.bits else 0.0

    @property
    def alternates(self) -> bool:
        """Return whether it is on in every other frame, or drifts through the frames slowly."""
        off = abs(self.rhythm.period - 2.0)
        near = 3.0 * self.rhythm.period_sigma + 2.0 * NEAR_HALF
        return self.rhythm.kind == 'wave' and off < near

    @property
    def repeats(self) -> bool:
        """Return whether it is a wave or a code, and no lamp."""
        return self.rhythm.kind in ('wave', 'code') and not self.mains

    @property
    def frames_per_bit(self) -> int:
        """Return the frames of a bit of a code; 0 where a free clock may be as near to them."""
        rhythm = self.rhythm
        sure = 0.0 < rhythm.bit_sigma < SURE_CLOCK * rhythm.bit
        return rhythm.frames_per_bit if sure else 0


class Survey:
    """
    Keep the points of frames, and find the lights among them that blink.

    Parameters
    ----------
    most : int
        Frames that are kept, the last ones.

    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._frames: list[tuple[int, Array, float]] = []
        self.crowded = False

    def push(self, points: Array, stamp_ns: int, least: float) -> NDArray[np.int64]:
        """Take the points of the next frame, as `BlinkTracker.update` does; return the kept."""
        self.crowded |= len(points) > MOST_POINTS
        kept = np.sort(np.argsort(-points[:, FLUX], kind='stable')[:MOST_POINTS])
        self._frames.append((stamp_ns, points[kept], least))
        if len(self._frames) > self._most:
            del self._frames[0]
        return kept

    @property
    def full(self) -> bool:
        """Return whether it has as many frames as it keeps."""
        return len(self._frames) == self._most

    @property
    def longest(self) -> float:
        """Return over how long the frames reach that it keeps, s; infinite before two came."""
        steps = len(self._frames) - 1
        return self.seconds * (self._most - 1) / steps if steps > 0 else math.inf

    @property
    def seconds(self) -> float:
        """Return for how long it has watched, s."""
        return (self._frames[-1][0] - self._frames[0][0]) / 1e9 if self._frames else 0.0

    @property
    def clock(self) -> tuple[Array, float]:
        """Return the times of the frames in frame intervals, and the interval, s."""
        return frame_times(np.array([stamp for stamp, _, _ in self._frames]))

    def lights(
        self, exposure: float = 0.0, *, sigmas: bool = True, most: int = MOST_LIGHTS
    ) -> list[Light]:
        """
        Return what blinks, or grows brighter and darker.

        Parameters
        ----------
        exposure : float
            Of a frame, s; 0 where nobody tells.
        sigmas : bool
            Whether standard deviations and aliases are asked for as well.
        most : int
            Paths that are looked at closely: those that are dark at times are the first, and of
            them those of the most points.

        """
        if len(self._frames) < FEWEST_POINTS:
            return []
        clock, interval = self.clock
        linker = PathLinker(interval)
        for time, (_, points, _) in zip(clock, self._frames):
            linker.update(points, float(time))
        least = float(np.median([each for _, _, each in self._frames]))
        found: list[Light] = []
        paths = [path for path in linker.paths(FEWEST_POINTS) if not _is_even(path)]
        for path in sorted(paths, key=_is_never_dark)[:most]:
            brightness = _brightness(path, clock, least)
            rhythm = recognise(brightness, min(exposure / interval, 1.0), sigmas=sigmas)
            if rhythm.kind in UNKNOWN and len(path.frames) < FEWEST_OF_UNKNOWN * len(clock):
                continue  # a reflection, a seam of a JPEG, a piece of another light's path
            if rhythm.kind != 'steady':
                found.append(_light(path, brightness, rhythm, interval, exposure, sigmas))
        return [
            light for index, light in enumerate(found)
            if not any(_is_rest(light, other) for other in found[:index])
        ]


def frame_times(stamps_ns: NDArray[np.int64]) -> tuple[Array, float]:
    """
    Return times in frame intervals, from 0, and the interval, s.

    Frames of a camera that keeps its rate are counted, whatever their stamps; those of one that
    does not have the times of their stamps.
    """
    seconds = (stamps_ns - stamps_ns[0]) / 1e9
    pace = float(np.median(np.diff(seconds)))
    count = np.concatenate([[0.0], np.cumsum(np.maximum(np.rint(np.diff(seconds) / pace), 1.0))])
    interval, begin = np.polyfit(count, seconds, 1)
    jitter = float(np.std(seconds - begin - interval * count))
    if jitter > JITTER * interval:
        return seconds / pace, pace
    return count, float(interval)


def _is_never_dark(path: Path) -> bool:
    """Tell whether a path is seen in nearly every frame."""
    span = path.frames[-1] + 1 - path.frames[0]
    return len(path.frames) > (1.0 - DARK) * span


def _is_even(path: Path) -> bool:
    """Tell whether it is of a lamp, or of the scene's texture: always there, and as bright."""
    low, middle, high = np.percentile(path.flux, [5.0, 50.0, 95.0])
    return _is_never_dark(path) and bool(high - low < EVEN * middle)


def mains_alias(frequency: float, sigma: float, rate: float) -> float:
    """Return 100 or 120 Hz where a lamp of it is seen at this frequency, else 0; all Hz."""
    for mains in MAINS_HZ:
        seen = abs(mains - rate * round(mains / rate))
        if abs(frequency - seen) < MAINS_OFF_HZ + 3.0 * sigma:
            return mains
    return 0.0


def _is_rest(light: Light, other: Light) -> bool:
    """Tell whether a light is another one, lost and found again on a path of its own."""
    own, its = light.rhythm, other.rhythm
    first, last = light.path.frames[[0, -1]]
    if first < other.path.frames[-1] and other.path.frames[0] < last:
        return False
    apart = abs(own.period - its.period)
    near = 3.0 * (own.period_sigma + its.period_sigma) + SAME_PERIOD * its.period
    return own.kind == its.kind and own.bits == its.bits and apart <= near


def _brightness(path: Path, clock: Array, least: float) -> Brightness:
    """Return what the frames from the first to the last one of a path show of it."""
    first, last = int(path.frames[0]), int(path.frames[-1])
    flux, sigma = np.zeros(last + 1 - first), np.ones(last + 1 - first)
    flux[path.frames - first], sigma[path.frames - first] = path.flux, path.sigma
    return Brightness(clock[first:last + 1], flux, sigma, least)


def _light(
    path: Path, brightness: Brightness, rhythm: Rhythm, interval: float, exposure: float,
    others: bool,
) -> Light:
    """Return a light with what it may be taken for."""
    light = Light(path, brightness, rhythm, 1.0 / interval)
    if rhythm.kind not in ('wave', 'modulated'):
        return light
    mains = mains_alias(light.frequency, light.frequency_sigma, light.rate)
    rates: list[float] = []
    if others and rhythm.kind == 'wave' and not light.alternates:
        rates = aliases(brightness, rhythm, exposure / interval, HIGHEST_HZ * interval)
    return Light(
        path, brightness, rhythm, light.rate, tuple(rate / interval for rate in rates), mains
    )
