"""Stamps that are not those of the frames, told by the motion of a light."""

from __future__ import annotations

from dataclasses import replace
import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.types import Location
import numpy as np

MEMORY = 64.0  # places, after which one weighs 1/e
FEWEST = 6.0  # places, before anything is said
SPARSE = 1.3  # times the usual interval, from which on a frame may be missing between places
PACE_PART = 0.1  # of an interval that is taken into the usual one
ACROSS = 0.05  # of what the stamps add along the way, across it: the way may turn
TOLD = 0.7  # of the jitter of the stamps, that the light's motion shows if they are true
SIGMAS = 3.0  # standard deviations below that, from which on they are not
SPOKEN_OF = 0.3  # of the variance of a place, from which on a warning says so
# Places in the state: of the last two places x, y, px, and their times, s; sums over the last
# places; standard deviation of the stamps, s; velocity, px/s; usual interval, s.
BEFORE, LAST, COUNT, UW, WW, UU, TT, SIGMA, VX, VY, PACE, SIZE = 0, 3, *range(6, 16)
LEAST_S = 2e-5  # s: stamps are not made more evenly than that
LONGEST_S = 1.0  # s from one place to the next but one


class StampJitter:
    """
    Measure by how much the stamps of a light's places are off.

    Of three places in a row the second difference of the times is d, that of the places u along
    the velocity v. Where the stamps are true, if uneven, u is v d in the mean; where they jitter
    about even frames it is none of it. With b the slope of u over v d

        sigma_t^2 = (1 - b) <d^2> / 6,

    and v v^T sigma_t^2 is in the covariance. A light at rest tells nothing, and loses nothing.

    Attributes
    ----------
    sigma : float
        Standard deviation of the stamps, s; 0 where they are true, or nothing is known yet.

    """

    def __init__(self) -> None:
        self._state = np.zeros(SIZE)
        self._first_ns: int | None = None

    @property
    def sigma(self) -> float:
        """Return the standard deviation of the stamps, s; 0 where they are true, or not known."""
        return self._state.item(SIGMA)

    def doubted(self, location: Location) -> Location:
        """Take the next place of the light; return it with the covariance that its stamp adds."""
        if self._first_ns is None:
            self._first_ns = location.stamp_ns
        if not _take(
            self._state, location.x, location.y, (location.stamp_ns - self._first_ns) / 1e9
        ):
            return location
        vx, vy = self._state[VX:PACE].tolist()
        across = (ACROSS * math.hypot(vx, vy)) ** 2
        added = self.sigma**2 * np.array(
            [[vx * vx + across, vx * vy], [vx * vy, vy * vy + across]]
        )
        covariance = location.covariance + added
        warning = location.warning
        if not warning and np.trace(added) > SPOKEN_OF * np.trace(location.covariance):
            away = self.sigma * math.hypot(vx, vy)
            warning = (
                f'the stamps jitter by {1e3 * self.sigma:.1f} ms, by which the light moves '
                f'{away:.2f} px: stamp the frames when they are exposed, not when they arrive'
            )
        return replace(location, covariance=covariance, warning=warning)


def compile_jitter() -> None:
    """Compile what looks at the stamps, or load it."""
    _take(np.zeros(SIZE), 0.0, 0.0, 0.0)


@kernel
def _take(state: Array, x: float, y: float, time: float) -> bool:
    """Take the next place, px, and its time, s; return whether the stamps are in doubt."""
    first, second = state[LAST + 2] - state[BEFORE + 2], time - state[LAST + 2]
    pace = 0.5 * (first + second)
    follows = min(first, second) > 0.0 and pace < LONGEST_S
    if follows and (state[PACE] == 0.0 or SPARSE * pace < state[PACE]):
        state[COUNT:SIGMA] = 0.0
        state[PACE] = pace
    here_x, here_y = x - state[LAST], y - state[LAST + 1]
    before_x, before_y = state[LAST] - state[BEFORE], state[LAST + 1] - state[BEFORE + 1]
    if follows and pace >= SPARSE * state[PACE]:
        state[VX] = (here_x + before_x) / (2.0 * pace)
        state[VY] = (here_y + before_y) / (2.0 * pace)
    elif follows:
        state[PACE] += PACE_PART * (pace - state[PACE])
        # Not by the times of the three, which may be wrong.
        state[VX] = (1.5 * here_x - 0.5 * before_x) / state[PACE]
        state[VY] = (1.5 * here_y - 0.5 * before_y) / state[PACE]
        vx, vy = 0.5 * (here_x + before_x) / state[PACE], 0.5 * (here_y + before_y) / state[PACE]
        speed = math.sqrt(vx * vx + vy * vy)
        uneven = second - first
        u = 0.0
        if speed > 0.0:
            u = (vx * (here_x - before_x) + vy * (here_y - before_y)) / speed
        w = speed * uneven
        for each in range(COUNT, SIGMA):
            state[each] *= 1.0 - 1.0 / MEMORY
        state[COUNT] += 1.0
        state[UW] += u * w
        state[WW] += w * w
        state[UU] += u * u
        state[TT] += uneven * uneven
        state[SIGMA] = 0.0
        if state[COUNT] > FEWEST and state[WW] > 0.0 and state[TT] > state[COUNT] * LEAST_S**2:
            slope = state[UW] / state[WW]
            rest = max(state[UU] - slope * state[UW], 0.0) / state[COUNT]
            if slope + SIGMAS * math.sqrt(rest / state[WW]) < TOLD:
                state[SIGMA] = math.sqrt(
                    (1.0 - max(slope, 0.0)) * state[TT] / state[COUNT] / 6.0
                )
    state[BEFORE:LAST] = state[LAST:COUNT]
    state[LAST], state[LAST + 1], state[LAST + 2] = x, y, time
    return state[SIGMA] > 0.0
