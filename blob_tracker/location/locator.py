"""Windows of lights in their order -> locations, with what the last ones tell of the next."""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from inspect import signature
import math
from typing import Any

from blob_tracker.location.doubt import LOPSIDED_LIGHT
from blob_tracker.location.effective_psf import EffectivePsf
from blob_tracker.location.estimates import Estimates
from blob_tracker.location.hypotheses import Motion, Pair
from blob_tracker.location.locate import estimate, METHODS, to_location
from blob_tracker.location.noise import noise_of_sum
from blob_tracker.location.suspicion import HEAD, LEANING
from blob_tracker.location.uneven_rows import variance_of_uneven_rows
from blob_tracker.types import Location, SensorNoise, Window
import numpy as np
from numpy.typing import NDArray

STEADIEST = 0.15  # px: the light's motion is not known better than that
ACCELERATING = 1.5  # of the last change of its displacement, that the next may have
LONGEST = 1.6  # of the last interval between two flashes, that the next may take
REMEMBERED = 32  # flashes, of which is told whether the light is the same in all
FEWEST = 8  # of them, before it can be
UNLIKE = 0.06  # of the light's mean, by which it differs from flash to flash where it flickers
SIGMAS = 5.0  # of what noise makes of that
WHOLE = 0.99  # of the exposure, for which a light is on that is as bright as ever
ROUND_PX = 1.0  # px of a streak, which takes no more than 2 % off the peak of a light of 1.5 px
TOGETHER = 5  # flashes over which a light's lopsidedness is summed


class _Memory:
    """The last flashes of one light."""

    def __init__(self) -> None:
        self.places: deque[tuple[int, float, float]] = deque(maxlen=3)
        self.light: deque[tuple[float, float]] = deque(maxlen=REMEMBERED)
        self.lopsided: deque[NDArray[np.float64]] = deque(maxlen=TOGETHER)

    def add(self, location: Location, alike: bool) -> None:
        """
        Take the next flash: where it was, how much light, and the noise of that over it.

        How bright it was counts where it was seen as in the other flashes.
        """
        self.places.append((location.stamp_ns, location.x, location.y))
        if not alike:
            return
        noise = 1.0 / (location.snr * max(location.sigma, 0.5))
        self.light.append((location.amplitude * location.sigma**2, noise))

    def motion(self, window: Window) -> Motion | None:
        """Return how the light should have moved since its last flash; None if unknown."""
        if len(self.places) < 3:
            return None
        stamps, x, y = np.array(self.places, dtype=float).T
        intervals = np.diff([*stamps, window.stamp_ns])
        if intervals.min() <= 0.0 or intervals.max() > LONGEST * intervals.min():
            return None
        velocity = np.diff(np.stack([x, y]), axis=1) / intervals[:2]
        flash = velocity[:, 1] * intervals[2]
        changed = (velocity[:, 1] - velocity[:, 0]) * intervals[2]
        scale = np.array(window.binning, dtype=float)
        deviation = max(STEADIEST, ACCELERATING * float(np.hypot(*(changed / scale))))
        place = np.array([x[-1] - window.x0, y[-1] - window.y0]) + flash + 0.5
        return Motion(flash / scale, deviation, place / scale - 0.5)

    def leaning(self, found: Estimates) -> NDArray[np.float64] | None:
        """Return how far the light's head is off the fit, window px; None where it is not."""
        self.lopsided.append(found.lopsided[0])
        score_x, score_y, x, y = np.sum(self.lopsided, axis=0)
        if not (x > 0.0 and y > 0.0):
            return None
        leaning = score_x**2 / x + score_y**2 / y
        if leaning < LEANING:
            return None
        return np.sqrt(1.0 - 2.0 / leaning) * HEAD * np.array([score_x / x, score_y / y])

    @property
    def flicker(self) -> float:
        """How much the light differs from flash to flash over its mean; 0 if noise may do so."""
        if len(self.light) < FEWEST:
            return 0.0
        light, noise = np.array(self.light).T
        # Of the differences: a light that comes nearer does not flicker.
        # Three quarters of them: bands leave some flashes alike, and something may pass once.
        unlike = float(np.quantile(np.abs(np.diff(light)), 0.75) / light.mean())
        return unlike if unlike > max(UNLIKE, SIGMAS * float(np.median(noise))) else 0.0


class Locator:
    """
    Place lights flash by flash, and remember the last flashes of each.

    A single pair of frames does not tell whether a second light in the unlit window is what is
    left of the flash, the last flash or a lamp behind the target, nor whether a dim flash was
    cut by the rows of a rolling shutter. The last places and brightnesses do. All that is
    remembered comes from windows, so that the same windows have the same locations in one
    process and in several.

    Parameters
    ----------
    method : str
        A key of `METHODS`.
    pulse : EffectivePsf, optional
        Learned pulse to fit in place of the Gaussian, for the method that takes one.
    **options
        Passed on to the method.

    Attributes
    ----------
    pulse : EffectivePsf or None
        As given; it may be set at any time.

    """

    def __init__(
        self, method: str = 'maximum_likelihood', *, pulse: EffectivePsf | None = None,
        **options: Any,
    ) -> None:
        self._method, self._options = method, options
        self.pulse = pulse
        self._remembers = 'motion' in signature(METHODS[method]).parameters
        self._memories: dict[str, _Memory] = {}

    def locate(self, window: Window, *, noise: SensorNoise, light: str = '') -> Location:
        """
        Locate the blob of the next window of a light.

        Parameters
        ----------
        window : Window
            Later than the last one of this light.
        noise : SensorNoise
            Of a pixel in one frame.
        light : str
            Its name.

        Returns
        -------
        Location
            See `locate`.

        Raises
        ------
        LocationError
            Where the blob cannot be placed.

        """
        options = dict(self._options)
        if self.pulse is not None:
            options['pulse'] = self.pulse
        memory = self._memories.setdefault(light, _Memory())
        if self._remembers:
            options['motion'] = memory.motion(window)
        found = estimate(window, method=self._method, noise=noise, **options)
        location = to_location(window, found)
        if found.lopsided.size:
            head = memory.leaning(found)
            if head is not None and not found.warnings:
                apart = head * np.array(window.binning)
                # A tail turns with the light's way: half of it to all sides.
                doubt = 0.5 * (np.outer(apart, apart) + apart @ apart * np.eye(2))
                location = replace(
                    location, covariance=location.covariance + doubt, warning=LOPSIDED_LIGHT
                )
        alike = _shines_as_ever(window)
        memory.add(location, alike)
        flicker = memory.flicker if alike else 0.0
        if self._remembers and flicker > 0.0 and not location.warning:
            location = _with_uneven_rows(location, window, noise, flicker)
        return location

    def forget(self, light: str | None = None) -> None:
        """Begin anew with a light, or with all of them."""
        if light is None:
            self._memories.clear()
        else:
            self._memories.pop(light, None)


def _shines_as_ever(window: Window) -> bool:
    """Tell whether a light was on for the whole exposure, and drew no streak."""
    glimpse = window.glimpse
    if glimpse is None:
        return True
    return glimpse.share >= WHOLE and float(np.hypot(*glimpse.way)) < ROUND_PX


def _with_uneven_rows(
    location: Location, window: Window, noise: SensorNoise, flicker: float
) -> Location:
    """Return the location of a light that flickers, which a rolling shutter may have moved."""
    noise = noise_of_sum(noise, window.looks)
    level = noise.black_level
    saturation = math.inf if window.saturation is None else window.saturation - level
    lit = np.asarray(window.lit, dtype=float) - level
    pair = Pair(lit, None, replace(noise, black_level=0.0), saturation)
    across, down = window.binning
    x = (location.x - window.x0 + 0.5) / across - 0.5
    y = (location.y - window.y0 + 0.5) / down - 0.5
    covariance = location.covariance.copy()
    level_of_fit = replace(location, background=location.background - level)
    covariance[1, 1] += down**2 * variance_of_uneven_rows(pair, level_of_fit, x, y)
    return replace(
        location,
        covariance=covariance,
        warning=f'the light flickers ({100.0 * flicker:.0f} % from flash to flash): if it is '
        'dimmed by PWM, a rolling shutter cuts it into bands across the rows, and y is not to '
        'be trusted; expose for whole periods of it, or use a global shutter',
    )
