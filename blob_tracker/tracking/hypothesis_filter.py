"""Initiate, predict and update a hypothesis."""

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.tracking.errors import PlatformGap
from blob_tracker.tracking.hypothesis import (
    FIRST_ACCELERATION_MRAD_S2, FIRST_RATE_MRAD_S, Hypothesis,
)
from blob_tracker.tracking.kalman import Innovation, Measurement
from blob_tracker.tracking.packed import initiated, predicted, updated
from blob_tracker.tracking.platform_rates import PlatformRates
from blob_tracker.tracking.platform_step import ProcessNoise, step_to


class Initiated(NamedTuple):
    """A hypothesis of one bearing, and why the platform's rotation is not in it."""

    hypothesis: Hypothesis
    platform_gap: str


class Updated(NamedTuple):
    """
    What a bearing makes of a hypothesis.

    Parameters
    ----------
    hypothesis : Hypothesis or None
        With the bearing; None if the gate refuses it.
    innovation : Innovation
        Of the bearing.
    sigma : float
        Largest standard deviation of the direction before it, mrad.
    platform_gap : str
        Why the platform's rotation is not in it; empty if it is, or if there is none.

    """

    hypothesis: Hypothesis | None
    innovation: Innovation
    sigma: float
    platform_gap: str


class HypothesisFilter:
    """
    The Kalman filter of one target on its platform.

    Parameters
    ----------
    size : int
        Numbers in the state, by the model.
    noise : ProcessNoise
        Of the target and of the platform.
    platform : PlatformRates or None
        Rotation of the base.

    """

    def __init__(self, size: int, noise: ProcessNoise, platform: PlatformRates | None) -> None:
        self._size, self._noise, self._platform = size, noise, platform

    def initiate(self, measurement: Measurement, stamp_ns: int) -> Initiated:
        """Return what a first bearing tells."""
        stabilised, gap = False, ''
        if self._platform is not None:
            try:
                self._platform.rate_at(stamp_ns)
                stabilised = True
            except PlatformGap as unknown:
                gap = str(unknown)
        state = initiated(
            *measurement, FIRST_RATE_MRAD_S, FIRST_ACCELERATION_MRAD_S2, self._size
        )
        return Initiated(Hypothesis(state, stamp_ns, stabilised, 1), gap)

    def predict(self, hypothesis: Hypothesis, stamp_ns: int) -> Hypothesis:
        """Return a hypothesis at another instant."""
        state, step, stabilised, _ = step_to(hypothesis, stamp_ns, self._noise, self._platform)
        return Hypothesis(predicted(state, *step), stamp_ns, stabilised, hypothesis.bearings)

    def update(
        self,
        hypothesis: Hypothesis,
        measurement: Measurement,
        stamp_ns: int,
        gate_sigma: float,
    ) -> Updated:
        """Return a hypothesis predicted to a bearing and, within the gate, updated by it."""
        state, step, stabilised, gap = step_to(hypothesis, stamp_ns, self._noise, self._platform)
        azimuth, elevation, rr, ru, uu, camera = measurement
        passed, state, first, second, log_determinant, sigma = updated(
            state, gate_sigma * gate_sigma, *step, azimuth, elevation, rr, ru, uu, camera
        )
        innovation = Innovation(first, second, log_determinant)
        if not passed:
            return Updated(None, innovation, sigma, gap)
        found = Hypothesis(state, stamp_ns, stabilised, hypothesis.bearings + 1)
        return Updated(found, innovation, sigma, gap)
