"""How a state is carried to another instant on a platform that turns."""

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.kernel import Array
from blob_tracker.tracking.errors import PlatformGap
from blob_tracker.tracking.hypothesis import (
    FIRST_ACCELERATION_MRAD_S2, FIRST_RATE_MRAD_S, Hypothesis,
)
from blob_tracker.tracking.kalman import Step
from blob_tracker.tracking.packed import with_motion_forgotten, with_rates
from blob_tracker.tracking.pan_tilt import PanTilt
from blob_tracker.tracking.platform_rates import PlatformRates
from blob_tracker.tracking.rotation import NO_TURN
from blob_tracker.units import MRAD

ADDED, TAKEN_OFF = 1.0, -1.0  # signs of a frame's rates


class ProcessNoise(NamedTuple):
    """
    Spectral densities of what is not modelled.

    Parameters
    ----------
    density, stabilised_density : float
        Of the target on its platform, and of the target alone, mrad^2/s^3 or mrad^2/s^5.
    platform_density : float
        Of the platform's acceleration past its last known rate, rad^2/s^3.

    """

    density: float
    stabilised_density: float
    platform_density: float


class PlatformStep(NamedTuple):
    """
    The state to predict from, and the step to predict it by.

    Parameters
    ----------
    state : array
        As `packed` has it, its rates those of the target alone or not.
    step : Step
        To the instant.
    stabilised : bool
        Whether the platform's rotation is in it.
    gap : str
        Why it is not, where it should be.

    """

    state: Array
    step: Step
    stabilised: bool
    gap: str


def step_to(
    hypothesis: Hypothesis, stamp_ns: int, noise: ProcessNoise, platform: PlatformRates | None
) -> PlatformStep:
    """Return how a hypothesis is stepped to an instant, by the platform's rotation if known."""
    state, since_ns, stabilised, _ = hypothesis
    seconds = 1e-9 * (stamp_ns - since_ns)
    unturned = Step(seconds, noise.density, NO_TURN, 0.0)
    if platform is None:
        return PlatformStep(state, unturned, False, '')
    try:
        turn, variance = platform.between(since_ns, stamp_ns)
        if not stabilised:
            state = _with_rates(state, platform.rate_at(since_ns), ADDED)
    except PlatformGap as gap:
        if stabilised:
            state = _unstabilised(hypothesis, platform)
        return PlatformStep(state, unturned, False, str(gap))
    variance += _variance_beyond(platform, noise.platform_density, since_ns, stamp_ns)
    step = Step(seconds, noise.stabilised_density, turn, variance / MRAD**2)
    return PlatformStep(state, step, True, '')


def as_seen(
    hypothesis: Hypothesis, platform: PlatformRates | None, pan_tilt: PanTilt | None
) -> tuple[Array, Array]:
    """
    Return a hypothesis with the rates of the picture.

    Returns
    -------
    array, (3, 3) array
        The state, still in the base, and the camera's axes in the base, as columns.

    Raises
    ------
    PlatformGap
        If the platform's rate or the pan/tilt's place is not known.

    """
    state, stamp_ns, stabilised, _ = hypothesis
    if stabilised and platform is not None:
        state = _with_rates(state, platform.rate_at(stamp_ns), TAKEN_OFF)
    if pan_tilt is None:
        return state, NO_TURN
    camera = pan_tilt.at(stamp_ns)
    return _with_rates(state, pan_tilt.rate_at(stamp_ns), TAKEN_OFF), camera


def _variance_beyond(
    platform: PlatformRates, density: float, t0_ns: int, t1_ns: int
) -> float:
    """
    Return the variance of the rotation past the newest rate, rad^2.

    The platform's acceleration is white noise of density q: after s seconds its rate is off
    by q s, and over the next t seconds its angle by q s t^2 + q t^3 / 3.
    """
    newest_ns = platform.newest_ns
    assert newest_ns is not None
    if t1_ns <= newest_ns:
        return 0.0
    stale = 1e-9 * max(0, t0_ns - newest_ns)
    seconds = 1e-9 * (t1_ns - max(t0_ns, newest_ns))
    return density * (stale + seconds / 3.0) * seconds**2


def _unstabilised(hypothesis: Hypothesis, platform: PlatformRates) -> Array:
    """Return the state with the rates that the platform's rotation leaves of them."""
    try:
        rate = platform.rate_at(hypothesis.stamp_ns)
    except PlatformGap:
        # Nobody knows how the base turned.
        return with_motion_forgotten(
            hypothesis.state, FIRST_RATE_MRAD_S, FIRST_ACCELERATION_MRAD_S2
        )
    return _with_rates(hypothesis.state, rate, TAKEN_OFF)


def _with_rates(state: Array, rotation: Array, sign: float) -> Array:
    """Return a state with the rates of a frame; its accelerations are as at first sight."""
    return with_rates(state, rotation, sign, FIRST_ACCELERATION_MRAD_S2)
