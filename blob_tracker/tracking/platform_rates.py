"""The platform's own rotation, from a gyro's angular velocity."""

from __future__ import annotations

from math import isfinite

from blob_tracker.kernel import Array, kernel
from blob_tracker.tracking.errors import PlatformGap, StampJump, TrackingError
from blob_tracker.tracking.rotation import from_vector, product
import numpy as np
from numpy.typing import ArrayLike, NDArray

CAPACITY = 4096  # samples: two seconds of 2 kHz, the fastest rate gyros give
FASTEST = 100.0  # rad/s: 6000 degrees a second, past the range of any gyro


class PlatformRates:
    """
    The rotation of the base between two instants, by its angular velocity.

    Between samples the angular velocity is linear in time. Over such an interval the turn is the
    exact one about the rotation vector

        (w0 + w1) dt / 2 + dt^2 / 12 (w0 x w1)

    whose second term is what the axis' own turning adds (Magnus expansion, fourth order; R. A.
    McKern, A Study of Transformation Algorithms, MIT 1968, calls it coning).

    Parameters
    ----------
    hold : float
        Longest time, s, that a rate holds: past the newest sample, and between two samples,
        beyond which the rotation counts as unknown.
    memory : float
        Time for which samples are kept, s; a late one within it is put in its place.

    Raises
    ------
    TrackingError
        Where one of them is not above 0 and finite.

    """

    def __init__(self, hold: float = 0.2, memory: float = 2.0) -> None:
        for name, value in (('hold', hold), ('memory', memory)):
            if not (value > 0.0 and isfinite(value)):
                raise TrackingError(f'{name} is {value} s; it must be above 0 and finite')
        self.hold = hold
        self.memory = memory
        self._hold_ns, self._memory_ns = round(1e9 * hold), round(1e9 * memory)
        self._stamps = np.empty(CAPACITY, np.int64)
        self._rates = np.empty((CAPACITY, 3))
        self._variances = np.empty(CAPACITY)
        self._first = self._end = 0  # of what is kept

    @property
    def newest_ns(self) -> int | None:
        """Stamp of the newest sample, ns; None where there is none."""
        return int(self._stamps[self._end - 1]) if self._end > self._first else None

    def reset(self) -> None:
        """Forget all samples."""
        self._first = self._end = 0

    def push(self, stamp_ns: int, rate: ArrayLike, variance: float = 0.0) -> None:
        """
        Take a sample.

        Parameters
        ----------
        stamp_ns : int
            ns of ROS time.
        rate : (3,) array
            Angular velocity of the base in its own axes (x right, y down, z forward), rad/s.
        variance : float
            Of each component's noise, which is white from sample to sample, (rad/s)^2.

        Raises
        ------
        TrackingError
            Where a number is none that can be, or there is a sample with this stamp.
        StampJump
            Where the stamp is from before the memory.

        """
        vector = np.asarray(rate, dtype=float)
        if vector.shape != (3,) or not np.abs(vector).max() <= FASTEST:
            raise TrackingError(
                f'the angular velocity is {vector.tolist()} rad/s; it must be 3 numbers within '
                f'+-{FASTEST:g}'
            )
        if not 0.0 <= variance < np.inf:
            raise TrackingError(
                f'the variance of the angular velocity is {variance} (rad/s)^2; it must be 0 or '
                'more and finite'
            )
        place = self._place(stamp_ns)
        for kept, value in (
            (self._stamps, stamp_ns), (self._rates, vector), (self._variances, variance)
        ):
            if place < self._end:
                kept[place + 1:self._end + 1] = kept[place:self._end].copy()
            kept[place] = value
        self._end += 1
        oldest = int(self._stamps[self._end - 1]) - self._memory_ns
        while self._stamps[self._first] < oldest:
            self._first += 1

    def between(self, t0_ns: int, t1_ns: int) -> tuple[NDArray[np.float64], float]:
        """
        Return the base's rotation from one instant to a later one.

        Parameters
        ----------
        t0_ns, t1_ns : int
            ns of ROS time; within `hold` past the newest sample the last rate goes on.

        Returns
        -------
        (3, 3) array
            Takes the components of a fixed vector in the base as it was at t0 to those in the base
            as it is at t1.
        float
            Variance that the samples' noise adds to each angle, rad^2.

        Raises
        ------
        PlatformGap
            Where the samples do not cover the time, with a reason.

        """
        samples = slice(self._first, self._end)
        turn, variance, gap = _integrated(
            self._stamps[samples], self._rates[samples], self._variances[samples], t0_ns, t1_ns,
            self._hold_ns,
        )
        if gap:
            raise PlatformGap(self._reason(gap, t0_ns, t1_ns))
        return turn, variance

    def rate_at(self, stamp_ns: int) -> NDArray[np.float64]:
        """
        Return the angular velocity at an instant, (3,), rad/s, linear between samples.

        Parameters
        ----------
        stamp_ns : int
            ns of ROS time.

        Raises
        ------
        PlatformGap
            As `between` does.

        """
        samples = slice(self._first, self._end)
        rate, gap = _rate(self._stamps[samples], self._rates[samples], stamp_ns, self._hold_ns)
        if gap:
            raise PlatformGap(self._reason(gap, stamp_ns, stamp_ns))
        return rate

    def _place(self, stamp_ns: int) -> int:
        """Return where a sample belongs, with room at the end."""
        if self._end == CAPACITY:
            # Half of it is room again for as many samples; the oldest go where all are within
            # the memory.
            first = max(self._first, CAPACITY // 2)
            count = CAPACITY - first
            for kept in (self._stamps, self._rates, self._variances):
                kept[:count] = kept[first:]
            self._first, self._end = 0, count
        newest = self.newest_ns
        if newest is None or stamp_ns > newest:
            return self._end
        if stamp_ns < newest - self._memory_ns:
            raise StampJump(
                f'the stamp of the angular velocity is {1e-9 * (newest - stamp_ns):.3f} s before '
                f'the newest one; at most {self.memory:g} s can be late'
            )
        samples = self._stamps[self._first:self._end]
        place = self._first + int(np.searchsorted(samples, stamp_ns))
        if self._stamps[place] == stamp_ns:
            raise TrackingError(f'there is an angular velocity with the stamp {stamp_ns} ns')
        return place

    def _reason(self, gap: int, t0_ns: int, t1_ns: int) -> str:
        newest = self.newest_ns
        if newest is None:
            return 'no angular velocity of the platform has come'
        if gap == BEFORE:
            return (
                f'the angular velocity of {1e-9 * (newest - t0_ns):.3f} s before the newest '
                'one is not kept'
            )
        if gap == AFTER:
            return (
                f'the newest angular velocity is {1e-9 * (t1_ns - newest):.3f} s old; it holds '
                f'for {self.hold:g} s'
            )
        return f'angular velocities are more than {self.hold:g} s apart'


BEFORE, AFTER, BETWEEN = 1, 2, 3  # where a gap is; 0 where there is none


@kernel
def _search(stamps: NDArray[np.int64], stamp: int) -> int:
    """Return how many stamps are not after one."""
    low, high = 0, len(stamps)
    while low < high:
        middle = (low + high) // 2
        if stamps[middle] <= stamp:
            low = middle + 1
        else:
            high = middle
    return low


@kernel
def _rate(
    stamps: NDArray[np.int64], rates: Array, stamp: int, hold: int
) -> tuple[Array, int]:
    """Return the angular velocity at an instant, and where there is a gap."""
    count = len(stamps)
    rate = np.zeros(3)
    after = _search(stamps, stamp)
    if after == 0:
        return rate, BEFORE
    before = after - 1
    if after == count:
        if stamp - stamps[before] > hold:
            return rate, AFTER
        rate[:] = rates[before]
        return rate, 0
    if stamps[after] - stamps[before] > hold:
        return rate, BETWEEN
    share = (stamp - stamps[before]) / (stamps[after] - stamps[before])
    for k in range(3):
        rate[k] = rates[before, k] + share * (rates[after, k] - rates[before, k])
    return rate, 0


@kernel
def _integrated(
    stamps: NDArray[np.int64], rates: Array, variances: Array, t0: int, t1: int, hold: int
) -> tuple[Array, float, int]:
    """Return the rotation, its variance, and where there is a gap."""
    turn = np.eye(3)
    count = len(stamps)
    variance = 0.0
    w0, gap = _rate(stamps, rates, t0, hold)
    if gap:
        return turn, variance, gap
    at = t0
    following = _search(stamps, t0)
    while at < t1:
        until = t1
        if following < count:
            until = min(t1, stamps[following])
        w1, gap = _rate(stamps, rates, until, hold)
        if gap:
            return turn, variance, gap
        dt = 1e-9 * (until - at)
        # A vector at rest turns against the base.
        cone = dt * dt / 12.0
        turn = product(from_vector(
            -0.5 * dt * (w0[0] + w1[0]) + cone * (w0[1] * w1[2] - w0[2] * w1[1]),
            -0.5 * dt * (w0[1] + w1[1]) + cone * (w0[2] * w1[0] - w0[0] * w1[2]),
            -0.5 * dt * (w0[2] + w1[2]) + cone * (w0[0] * w1[1] - w0[1] * w1[0]),
        ), turn)
        if following < count:
            # Each sample speaks for half the intervals beside it: its variance over its time
            # squared, shared out evenly over the interval so that parts add up to the whole.
            interval = 1e-9 * (stamps[following] - stamps[following - 1])
            variance += 0.5 * (variances[following - 1] + variances[following]) * interval * dt
        else:
            variance += variances[count - 1] * dt * dt
        w0, at = w1, until
        following += 1
    return turn, variance, 0
