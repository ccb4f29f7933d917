"""Windows of lights in their order -> locations, with what the last ones tell of the next."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
import math
from typing import Any

from blob_tracker.location.doubt import LOPSIDED_LIGHT
from blob_tracker.location.effective_psf import EffectivePsf
from blob_tracker.location.estimates import Estimate, Estimates
from blob_tracker.location.flash_memory import FlashMemory
from blob_tracker.location.hypotheses import Pair
from blob_tracker.location.learned_pulse import compile_fit
from blob_tracker.location.locate import estimate, PARAMETERS, plain, to_location, UNASKED
from blob_tracker.location.noise import noise_of_sum
from blob_tracker.location.pulse_learner import compile_ahead, PulseLearner
from blob_tracker.location.uneven_rows import variance_of_uneven_rows
from blob_tracker.types import Location, SensorNoise, Window
import numpy as np
from numpy.typing import NDArray

# Models of a round light that is in both frames: what the one lacks may be in the other.
IN_BOTH_FRAMES = ('ghost', 'smeared', 'switched')
ROUND_MODELS = ('', *IN_BOTH_FRAMES)
CUT_UNSEEN = (
    'the flash switched while the rows of the light were exposed, in the last flashes: shift its '
    'phase, shorten the exposure or use a global shutter'
)
BETWEEN_SITES_PX = 1.0  # sigma, below which few of the samples, 2 px apart, have its light
WHOLE = 0.99  # of the exposure, for which a light is on that is as bright as ever
ROUND_PX = 1.0  # px of a streak, which takes no more than 2 % off the peak of a light of 1.5 px


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
    learn : bool
        Learn the pulse of each light, for the method that takes one: see `PulseLearner`. It is
        done in `learn`, which is to be called after each flash.
    **options
        Passed on to the method.

    Raises
    ------
    ValueError
        If a pulse is to be learned for a method that takes none.

    Attributes
    ----------
    learners : dict
        By the light's name, the `PulseLearner` of each; empty if nothing is learned.

    Examples
    --------
    The place on the sensor, px; not all methods take a learned pulse:

    >>> import numpy as np
    >>> y, x = np.mgrid[:15, :15]
    >>> pulse = 150.0 * np.exp(-((x - 7.3) ** 2 + (y - 6.5) ** 2) / (2.0 * 2.0**2))
    >>> window = Window(lit=(40.0 + pulse).round().astype(np.uint8), x0=100, saturation=255)
    >>> location = Locator().locate(window, noise=SensorNoise(gain=40.0, read_noise=0.7))
    >>> round(location.x, 1), round(location.y, 1)
    (107.3, 6.5)
    >>> Locator('centroid', learn=True)
    Traceback (most recent call last):
        ...
    ValueError: the method 'centroid' takes no learned pulse

    """

    def __init__(
        self, method: str = 'maximum_likelihood', *, pulse: EffectivePsf | None = None,
        learn: bool = False, **options: Any,
    ) -> None:
        self._method, self._options = method, options
        self._pulse: EffectivePsf | None = None
        self.pulse = pulse
        self._learns = learn
        self.learners: dict[str, PulseLearner] = {}
        if learn:
            if 'pulse' not in PARAMETERS[method]:
                raise ValueError(f"the method '{method}' takes no learned pulse")
            compile_ahead()
        self._elliptical = bool(options.get('elliptical', False))
        self._is_plain = options.keys() <= UNASKED
        self._remembers = 'history' in PARAMETERS[method]
        self._memories: dict[str, FlashMemory] = {}

    @property
    def pulse(self) -> EffectivePsf | None:
        """Learned pulse that is fitted in place of the Gaussian; it may be set at any time."""
        return self._pulse

    @pulse.setter
    def pulse(self, pulse: EffectivePsf | None) -> None:
        if pulse is not None:
            compile_fit(pulse)
        self._pulse = pulse

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
            If the blob cannot be placed.

        """
        memory = self._memories.get(light)
        if memory is None:
            memory = self._memories[light] = FlashMemory()
        found = None
        if not self._learns and self._pulse is None and self._is_plain:
            found = plain(window, self._method, noise, elliptical=self._elliptical)
        if found is None:
            found = self._estimate(window, noise, light, memory)
        location = to_location(window, found)
        if found.way is not None and window.glimpse is None:
            location = _on_its_path(location, memory, found.way * window.binning)
        evidence = found.evidence
        model = max(evidence, key=evidence.__getitem__) if evidence else ''
        drawn = found.drawn * window.binning[1]
        cut = memory.drawn if self._remembers and not drawn else 0.0
        alike = _shines_as_ever(window) and not _is_between_sites(window, location)
        beside = found.beside
        if beside is not None:
            beside = replace(beside, shift=beside.shift * window.binning)
        memory.add(
            location, evidence, lopsided=found.lopsided, beside=beside, drawn=drawn,
            # Amplitude and sigma of another shape are not those of a round one.
            alike=alike and model in ROUND_MODELS,
        )
        doubt = memory.doubt
        if doubt is not None and not found.warning:
            location = replace(
                location,
                covariance=location.covariance + doubt * np.outer(window.binning, window.binning),
                warning=LOPSIDED_LIGHT,
            )
        if cut:
            location = _with_cut_rows(location, cut)
        flicker = memory.flicker if alike else 0.0
        if self._remembers and flicker > 0.0 and model not in IN_BOTH_FRAMES:
            location = _with_uneven_rows(location, window, noise, flicker)
        return location

    def _estimate(
        self, window: Window, noise: SensorNoise, light: str, memory: FlashMemory
    ) -> Estimate:
        """Return the estimate of a window about which something may be odd."""
        options = self._options
        if self._remembers:
            options = {**options, 'history': partial(memory.history, window)}
        if self._learns:
            return self._learned(window, noise, light, options)
        if self.pulse is not None:
            options = {**options, 'pulse': self.pulse}
        return estimate(window, method=self._method, noise=noise, **options).first()

    def _learned(
        self, window: Window, noise: SensorNoise, light: str, options: dict[str, Any]
    ) -> Estimate:
        """Return the estimate by the pulse that is learned, and have it learned."""
        if 'history' in options:
            known = options['history']()  # the learner asks when this flash is part of it
            options = {**options, 'history': lambda: known}

        def placed(pulse: EffectivePsf | None) -> Estimates:
            given = {} if pulse is None else {'pulse': pulse}
            return estimate(window, method=self._method, noise=noise, **options, **given)

        learner = self.learners.setdefault(light, PulseLearner())
        found = placed(learner.pulse or self.pulse)
        learner.take(window, noise, found, lambda: placed(self.pulse))
        return found.first()

    def learn(self, light: str = '') -> None:
        """Learn from the last window of a light, for a millisecond; its bearing is out by now."""
        if light in self.learners:
            self.learners[light].work()

    def forget(self, light: str | None = None) -> None:
        """Begin anew with a light, or with all of them."""
        if light is None:
            self._memories.clear()
        else:
            self._memories.pop(light, None)


def _on_its_path(
    location: Location, memory: FlashMemory, way: NDArray[np.float64]
) -> Location:
    """Return the location of a light that draws a streak: in the middle of its exposure."""
    bent = memory.lag(location, way)
    if bent is None:
        return location
    (lag_x, lag_y), unsure = bent
    return replace(
        location, x=location.x - lag_x, y=location.y - lag_y,
        covariance=location.covariance + unsure,
    )


def _shines_as_ever(window: Window) -> bool:
    """Tell whether a light was on for the whole exposure, and drew no streak."""
    glimpse = window.glimpse
    if glimpse is None:
        return True
    return glimpse.share >= WHOLE and float(np.hypot(*glimpse.way)) < ROUND_PX


def _is_between_sites(window: Window, location: Location) -> bool:
    """Tell whether a light is too narrow for the samples of a mosaic to tell its brightness."""
    return window.sites is not None and location.sigma < BETWEEN_SITES_PX


def _with_cut_rows(location: Location, variance: float) -> Location:
    """Return the location of a light whose rows were cut in the last flashes, but not seen now."""
    covariance = location.covariance.copy()
    covariance[1, 1] += variance
    return replace(location, covariance=covariance, warning=location.warning or CUT_UNSEEN)


def _with_uneven_rows(
    location: Location, window: Window, noise: SensorNoise, flicker: float
) -> Location:
    """Return the location of a light that flickers, which a rolling shutter may have moved."""
    noise = noise_of_sum(noise, window.looks)
    level = noise.black_level
    saturation = math.inf if window.saturation is None else window.saturation - level
    lit = np.asarray(window.lit, dtype=float) - level
    pair = Pair(lit, None, replace(noise, black_level=0.0), saturation)
    x, y = window.to_window(location.x, location.y)
    covariance = location.covariance.copy()
    level_of_fit = replace(location, background=location.background - level)
    covariance[1, 1] += window.binning[1] ** 2 * variance_of_uneven_rows(pair, level_of_fit, x, y)
    return replace(
        location,
        covariance=covariance,
        warning=f'the light flickers ({100.0 * flicker:.0f} % from flash to flash): if it is '
        'dimmed by PWM, a rolling shutter cuts it into bands across the rows, and y is not to '
        'be trusted; expose for whole periods of it, or use a global shutter',
    )
