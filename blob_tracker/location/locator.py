"""Windows of lights in their order -> locations, with what the last ones tell of the next."""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from inspect import signature
from typing import Any

from blob_tracker.location.doubt import LOPSIDED_LIGHT
from blob_tracker.location.estimates import Estimates, Failure, REASONS
from blob_tracker.location.hypotheses import Motion
from blob_tracker.location.locate import estimate, METHODS, to_location
from blob_tracker.location.suspicion import HEAD, LEANING, Suspicion
from blob_tracker.types import Location, LocationError, SensorNoise, Window
import numpy as np
from numpy.typing import NDArray

STEADIEST = 0.15  # px: the light's motion is not known better than that
ACCELERATING = 1.5  # of the last change of its displacement, that the next may have
LONGEST = 1.6  # of the last interval between two flashes, that the next may take
REMEMBERED = 16  # flashes of which bands are told
FEWEST = 6  # of them, before any can be
UNLIKE = 0.08  # of the light's mean, by which it differs from flash to flash in bands
TOGETHER = 5  # flashes over which a light's lopsidedness is summed
ODD = 0.25  # of the flashes, that are not round pulses in bands


class _Memory:
    """The last flashes of one light."""

    def __init__(self) -> None:
        self.places: deque[tuple[int, float, float]] = deque(maxlen=3)
        self.light: deque[float] = deque(maxlen=REMEMBERED)
        self.odd: deque[bool] = deque(maxlen=REMEMBERED)
        self.lopsided: deque[NDArray[np.float64]] = deque(maxlen=TOGETHER)

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
    def banded(self) -> bool:
        """Whether the flashes are as bands across the rows make them."""
        if len(self.light) < FEWEST:
            return False
        light = np.array(self.light)
        # Of the differences: a light that comes nearer is no band.
        unlike = float(np.median(np.abs(np.diff(light)))) > UNLIKE * float(light.mean())
        return unlike and float(np.mean(self.odd)) > ODD


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
    **options
        Passed on to the method.

    """

    def __init__(self, method: str = 'maximum_likelihood', **options: Any) -> None:
        self._method, self._options = method, options
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
            Where the blob cannot be placed, or the last flashes say that its place is wrong.

        """
        options = dict(self._options)
        memory = self._memories.setdefault(light, _Memory())
        if self._remembers:
            options['motion'] = memory.motion(window)
        found = estimate(window, method=self._method, noise=noise, **options)
        if self._remembers and found.odd.size:
            suspicion = Suspicion(int(found.odd[0]))
            banded = found.failure[0] == Failure.BANDED
            if banded or found.ok[0]:
                explained = bool(found.warnings) and not banded
                odd = not explained and bool(suspicion & (Suspicion.AXES | Suspicion.ROWS))
                memory.odd.append(banded or odd)
                memory.light.append(float(found.amplitude[0] * found.sigma[0] ** 2))
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
        memory.places.append((window.stamp_ns, location.x, location.y))
        if memory.banded:
            raise LocationError(REASONS[Failure.BANDED])
        return location

    def forget(self, light: str | None = None) -> None:
        """Begin anew with a light, or with all of them."""
        if light is None:
            self._memories.clear()
        else:
            self._memories.pop(light, None)
