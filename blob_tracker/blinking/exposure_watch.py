"""Whether lights are partly lit as often as the exposure that was told would see them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from blob_tracker.blinking.patterns import Pattern, SHARE_LEVELS, Tables, tables
from blob_tracker.blinking.phase import (
    diffuse, fill_hit, fill_miss, fill_prior, fill_steps, learned_wander, NEAR_SHARE, NOTHING,
    OTHERS, Steps, weigh_hit, weigh_miss, where,
)
from blob_tracker.kernel import Array, kernel
import numpy as np
from numpy.typing import NDArray

# Times the told exposure. The first of them are not told from it: a light that keeps its phase, or
# moves, shows a share that is a little off in frame after frame.
RATIOS = 2.0 ** np.array([0.0, -0.5, 0.5, -1.5, -1.0, 1.0, 1.5])
MOST_ALIKE = 1.5
MEMORY_FRAMES = 300.0  # after which a look weighs 1/e
TURN_FRAMES = 1200  # for which a light is watched, before it is another one's turn
# At the begin of its turn it is looked at in each frame, and as long as another exposure is
# likelier; then in one of so many. No wave that is slower than the frames is in step with a prime.
CLOSE_FRAMES, SELDOM_FRAMES = 150, 17
# nats by which another exposure must be more likely, and stay so; by which it is looked into
CONTRADICTION, STILL_CONTRADICTION, SUSPICION = 12.0, 6.0, 2.0


class _Light(NamedTuple):
    """A light's tables for the told exposure; levels, weights and wander for each; its prior."""

    looks: Tables
    levels: NDArray[np.uint8]
    prior: Array
    weights: Array
    wander: Array


class ExposureWatch:
    """
    Hold an exposure against the lights that are seen in it.

    A light that is switched while it is exposed shows a share of its flux. How often, and in which
    phases, tells how long the exposure is. The phase of each light is followed for each of some
    exposures; where the looks at all of them are far less likely with that which was told than
    with another, it was told wrongly, or they are not just on or off: they fade.

    One light at a time is watched, first in each frame and then in a few: the exposure is that of
    all of them, and does not change by itself. What is in step with the frames shows the same
    shares whatever the exposure, and has no turn.

    Parameters
    ----------
    patterns : sequence of Pattern
        The lights.
    interval, exposure : float
        From frame to frame, and of a frame as it was told, s.

    Attributes
    ----------
    ratio : float
        Of the likeliest exposure to that which was told; 1 while that may be right.

    """

    def __init__(self, patterns: Sequence[Pattern], interval: float, exposure: float) -> None:
        self.ratio = 1.0
        self._patterns, self._interval, self._exposure = patterns, interval, exposure
        self._ratios = RATIOS[RATIOS * exposure <= max(interval, exposure)]
        # As wide for all of them, or a light that keeps its phase were likelier with a longer one.
        # NEAR_SHARE is for half of a frame.
        self._near = 0.5 * NEAR_SHARE * interval / exposure
        self._alike = np.abs(np.log(self._ratios)) < np.log(MOST_ALIKE)
        self._evidence = np.zeros(self._ratios.size)
        self._lights: dict[int, _Light] = {}
        self._watched, self._turn, self._since = -1, 0, 0  # in frames: its turn, the last look
        self._doubted = False
        self._on, self._likelihood = np.zeros(1, np.int64), np.zeros(SHARE_LEVELS + 1)

    def is_due(self) -> bool:
        """Take note of a frame; tell whether a light is to be looked at in it."""
        self._turn += 1
        self._since += 1
        return (
            self._turn <= CLOSE_FRAMES or self._doubted or self._since >= SELDOM_FRAMES
        )

    def whose_turn(self, sure: Sequence[int]) -> int | None:
        """Return which of the lights that are sure is to be looked at; None where none is."""
        free = [name for name in sure if self._patterns[name].frames == 0]
        if not free:
            return None
        if self._watched not in free or self._turn > TURN_FRAMES:
            self._watched = next((name for name in free if name > self._watched), free[0])
            self._turn = self._since = 0
            light = self._lights.get(self._watched)
            if light is not None:  # its phase then is not known by now
                light.weights[:], light.wander[:] = light.prior, 1.0
        return self._watched

    def add(
        self, name: int, clock: float, flux: tuple[float, float] | None, full: Array, least: float
    ) -> None:
        """
        Take the next look at a light.

        Parameters
        ----------
        name : int
            Index of its pattern.
        clock : float
            When its line was exposed, frame intervals.
        flux : (float, float) or None
            Of its point, and the standard deviation, DN px^2; None where it was not seen.
        full : (6,) array
            Of its track, see `Tracks`.
        least : float
            Flux of which half is seen.

        """
        light = self._lights.get(name)
        if light is None:
            light = self._lights[name] = self._new_light(self._patterns[name])
        passed = min(max(self._since, 1), SELDOM_FRAMES)
        self._since = 0
        self._evidence *= (1.0 - 1.0 / MEMORY_FRAMES) ** passed
        _weigh(
            *light, self._evidence, self._near, np.array([clock]), self._on,
            np.array((-1.0, 0.0) if flux is None else flux), full, least, self._likelihood, passed,
        )
        best = int(np.argmax(self._evidence))
        lead = float(self._evidence[best] - self._evidence[self._alike].max())
        self._doubted = lead > SUSPICION
        needed = CONTRADICTION if self.ratio == 1.0 else STILL_CONTRADICTION
        self.ratio = 1.0 if lead < needed else float(self._ratios[best])

    def _new_light(self, pattern: Pattern) -> _Light:
        each = [
            tables([pattern], self._interval, ratio * self._exposure)
            for ratio in self._ratios.tolist()
        ]
        first = each[0].first
        prior = np.zeros(int(first[-1]) + OTHERS)
        fill_prior(first, prior)
        return _Light(
            each[0], np.stack([those.level for those in each]), prior,
            np.tile(prior, (len(each), 1)), np.ones(len(each)),
        )


@kernel
def _weigh(
    looks: Tables, levels: NDArray[np.uint8], prior: Array, weights: Array, wander: Array,
    evidence: Array, near: float, clock: Array, on: Steps, flux: Array, full: Array, least: float,
    likelihood: Array, passed: int,
) -> None:
    """Weigh the phases of each exposure by a look, frames later; add up how likely it was."""
    fill_steps(looks, clock, 0.0, on)
    if flux[0] >= 0.0:
        fill_hit(flux[0], flux[1], full, least, likelihood, near)
    else:
        fill_miss(full, least, likelihood)
    for k in range(evidence.size):
        one = Tables(looks.first, looks.rate, levels[k], looks.tau, looks.share, looks.slope)
        for _ in range(passed):
            diffuse(looks.first, prior, weights[k], 0, wander[k])
        about, mean, variance = where(looks.first, weights[k], 0, -1)
        if flux[0] >= 0.0:
            total = weigh_hit(one, on, weights[k], 0, likelihood)
        else:
            total = weigh_miss(one, on, weights[k], 0, likelihood)
        _, new_mean, new_variance = where(looks.first, weights[k], 0, about)
        wander[k] = learned_wander(wander[k], mean, variance, new_mean, new_variance)
        evidence[k] += np.log(max(total, NOTHING))
