"""Windows of lights in their order -> locations, with what the last ones tell of the next."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import replace
from inspect import signature
import math
from typing import Any

from blob_tracker.location.doubt import LOPSIDED_LIGHT
from blob_tracker.location.effective_psf import EffectivePsf
from blob_tracker.location.estimates import Estimates
from blob_tracker.location.hypotheses import History, Motion, Pair
from blob_tracker.location.locate import estimate, METHODS, to_location
from blob_tracker.location.noise import noise_of_sum
from blob_tracker.location.pulse_learner import compile_ahead, PulseLearner
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
SUMMED = 64  # flashes, over which a light's lopsidedness is summed
# A chi-square of two degrees of freedom that noise exceeds once in 1e4: of a light's lopsidedness,
# summed over these flashes
LOPSIDED_FLASHES = 18.4
NO_EVIDENCE: Mapping[str, float] = {}  # that the light is anything but one round pulse
LEAST_WAY_PX = 1.0  # px from flash to flash, beyond which it is known where the light goes


class _Sums:
    """Sums over the last flashes of lopsidedness: two scores and their variances' inverse."""

    def __init__(self) -> None:
        self.sums = [0.0, 0.0, 0.0, 0.0]
        self._terms: deque[tuple[float, ...]] = deque()

    @property
    def flashes(self) -> int:
        """How many there are."""
        return len(self._terms)

    def add(self, *terms: float) -> None:
        """Take the next flash."""
        self._terms.append(terms)
        self.sums = [total + term for total, term in zip(self.sums, terms)]
        if len(self._terms) > SUMMED:
            self.sums = [
                total - term for total, term in zip(self.sums, self._terms.popleft())
            ]


def _leaning(sums: Sequence[float]) -> float:
    """Return the chi-square of summed lopsidedness; 0 where there is none yet."""
    score_x, score_y, x, y = sums
    if not (x > 0.0 and y > 0.0):
        return 0.0
    return score_x**2 / x + score_y**2 / y


class _Memory:
    """The last flashes of one light. In Python's own numbers: arrays of three cost more time."""

    def __init__(self) -> None:
        self._places: deque[tuple[int, float, float]] = deque(maxlen=3)
        self._light: deque[float] = deque(maxlen=REMEMBERED)
        self._unlike: deque[float] = deque(maxlen=REMEMBERED - 1)  # from one flash to the next
        self._noise: deque[float] = deque(maxlen=REMEMBERED)  # of the light, over it
        self._evidence: deque[Mapping[str, float]] = deque(maxlen=REMEMBERED)
        self._lopsided = _Sums()  # along x and y
        self._trailing = _Sums()  # along the light's way, and across it

    def add(self, location: Location, evidence: Mapping[str, float]) -> None:
        """Take the next flash: where and how bright it was, and which models spoke for it."""
        self._places.append((location.stamp_ns, location.x, location.y))
        light = location.amplitude * location.sigma**2
        if self._light:
            self._unlike.append(abs(light - self._light[-1]))
        self._light.append(light)
        self._evidence.append(evidence)
        self._noise.append(1.0 / (location.snr * max(location.sigma, 0.5)))

    def history(self, window: Window) -> History:
        """Return what the last flashes say of the next one."""
        evidence = [each for each in self._evidence if each]
        return History(self._motion(window), self._even, evidence)

    @property
    def _even(self) -> bool:
        """Whether enough flashes are remembered, and lean to no side in their sum."""
        return self._lopsided.flashes >= FEWEST and max(
            _leaning(self._lopsided.sums), _leaning(self._trailing.sums)
        ) < LEANING

    def _motion(self, window: Window) -> Motion | None:
        """Return how the light should have moved since its last flash; None if unknown."""
        if len(self._places) < 3:
            return None
        (t0, x0, y0), (t1, x1, y1), (t2, x2, y2) = self._places
        first, second, last = t1 - t0, t2 - t1, window.stamp_ns - t2
        least = min(first, second, last)
        if least <= 0 or max(first, second, last) > LONGEST * least:
            return None
        across, down = window.binning
        flash_x, flash_y = (x2 - x1) * last / second, (y2 - y1) * last / second
        changed = math.hypot(
            (flash_x - (x1 - x0) * last / first) / across,
            (flash_y - (y1 - y0) * last / first) / down,
        )
        return Motion(
            np.array([flash_x / across, flash_y / down]),
            max(STEADIEST, ACCELERATING * changed),
            np.array([
                (x2 - window.x0 + flash_x + 0.5) / across - 0.5,
                (y2 - window.y0 + flash_y + 0.5) / down - 0.5,
            ]),
        )

    def leaning(
        self, found: Estimates, location: Location
    ) -> NDArray[np.float64] | None:
        """
        Return the covariance that a lopsided light has beside its fit's, window px^2.

        Coma and a lamp beside the light stay where they are in the picture; the tail of a shutter
        that leaks, or of a light that fades, turns with the light's way.
        """
        score_x, score_y, x, y = found.lopsided[0].tolist()
        self._lopsided.add(score_x, score_y, x, y)
        axes, sums = np.eye(2), self._lopsided.sums
        way = self._way(location)
        if way is not None:
            u, v = way
            self._trailing.add(
                u * score_x + v * score_y, v * score_x - u * score_y,
                u * u * x + v * v * y, v * v * x + u * u * y,
            )
            if _leaning(self._trailing.sums) > _leaning(sums):
                axes, sums = np.array([[u, v], [v, -u]]), self._trailing.sums
        leaning = _leaning(sums)
        if leaning < LOPSIDED_FLASHES:
            return None
        head = HEAD * np.array([sums[0] / sums[2], sums[1] / sums[3]]) @ axes
        return (1.0 - 2.0 / leaning) * np.outer(head, head)

    def _way(self, location: Location) -> tuple[float, float] | None:
        """Return the unit vector of where the light goes in this flash; None if it stands."""
        if len(self._places) < 2:
            return None
        (t0, x0, y0), (t1, x1, y1) = list(self._places)[-2:]
        t2, x2, y2 = location.stamp_ns, location.x, location.y
        if not 0 < t2 - t1 <= LONGEST * (t1 - t0) or t1 - t0 > LONGEST * (t2 - t1):
            return None
        # Of the parabola through the three.
        u, v = (
            1.5 * (c - b) - 0.5 * (b - a) * (t2 - t1) / (t1 - t0)
            for a, b, c in ((x0, x1, x2), (y0, y1, y2))
        )
        speed = math.hypot(u, v)
        return (u / speed, v / speed) if speed > LEAST_WAY_PX else None

    @property
    def flicker(self) -> float:
        """How much the light differs from flash to flash over its mean; 0 if noise may do so."""
        count = len(self._light)
        if count < FEWEST:
            return 0.0
        # Of the differences: a light that comes nearer does not flicker.
        # Three quarters of them: bands leave some flashes alike, and something may pass once.
        unlike = sorted(self._unlike)[3 * len(self._unlike) // 4] * count / sum(self._light)
        if unlike <= UNLIKE:
            return 0.0
        return unlike if unlike > SIGMAS * sorted(self._noise)[count // 2] else 0.0


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
        Where a pulse is to be learned for a method that takes none.

    Attributes
    ----------
    pulse : EffectivePsf or None
        As given; it may be set at any time.
    learners : dict
        By the light's name, the `PulseLearner` of each; empty where nothing is learned.

    """

    def __init__(
        self, method: str = 'maximum_likelihood', *, pulse: EffectivePsf | None = None,
        learn: bool = False, **options: Any,
    ) -> None:
        self._method, self._options = method, options
        self.pulse = pulse
        self._learns = learn
        self.learners: dict[str, PulseLearner] = {}
        parameters = signature(METHODS[method]).parameters
        if learn:
            if 'pulse' not in parameters:
                raise ValueError(f"the method '{method}' takes no learned pulse")
            compile_ahead()
        self._remembers = 'history' in parameters
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
        memory = self._memories.get(light)
        if memory is None:
            memory = self._memories[light] = _Memory()
        if self._remembers:
            options['history'] = memory.history(window)

        def placed(pulse: EffectivePsf | None) -> Estimates:
            given = {} if pulse is None else {'pulse': pulse}
            return estimate(window, method=self._method, noise=noise, **options, **given)

        if self._learns:
            learner = self.learners.setdefault(light, PulseLearner())
            found = placed(learner.pulse or self.pulse)
            learner.take(window, noise, found, lambda: placed(self.pulse))
        else:
            found = placed(self.pulse)
        location = to_location(window, found)
        if found.lopsided.size:
            doubt = memory.leaning(found, location)
            if doubt is not None and not found.warnings:
                doubt *= np.outer(window.binning, window.binning)
                location = replace(
                    location, covariance=location.covariance + doubt, warning=LOPSIDED_LIGHT
                )
        memory.add(location, found.evidence.get(0, NO_EVIDENCE))
        flicker = memory.flicker
        if self._remembers and flicker > 0.0 and not location.warning:
            location = _with_uneven_rows(location, window, noise, flicker)
        return location

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
