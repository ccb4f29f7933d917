"""The platform's own rotation, from a gyro's angular velocity."""

from __future__ import annotations

from math import isfinite

from blob_tracker.kernel import Array, kernel
from blob_tracker.tracking.errors import check_stamp, PlatformGap, StampJump, TrackingError
from blob_tracker.tracking.rotation import from_vector, product
import numpy as np
from numpy.typing import ArrayLike, NDArray

DENSEST = 4000  # samples a second of the memory: twice as fast as a fused gyro publishes
# s of samples to which a line is fitted: a longer one follows a turn too late, a shorter one the
# noise and the engine. On a boat 0.05 to 0.07 are alike (study servo).
FITTED = 0.06
FEWEST = 4  # samples of a line; of fewer the newest holds
# s that they span at least: of a burst, stamped on arrival, the slope is noise over microseconds.
SHORTEST = FITTED / 2.0
# rad/s^2: past what a vehicle's drive, a rock under its tool or a camera drone's rotors give it.
SWIFTEST = 100.0
SHAKEN = 0.3  # rad/s from sample to sample: a gyro's noise and what an engine shakes it by
FASTEST = 100.0  # rad/s: 6000 degrees a second, past the range of any gyro


class PlatformRates:
    """
    The rotation of the base between two instants, by its angular velocity.

    Between samples the angular velocity is linear in time. Over such an interval the turn is the
    exact one about the rotation vector

        (w0 + w1) dt / 2 + dt^2 / 12 (w0 x w1)

    whose second term is what the axis' own turning adds (Magnus expansion, fourth order; R. A.
    McKern, A Study of Transformation Algorithms, MIT 1968, calls it coning).

    Past the newest sample the angular velocity goes on along a straight line, the least-squares
    fit to the samples of the last `FITTED` seconds, whose weights rise evenly from 0 to 1 at the
    newest; of fewer than `FEWEST` or within less than `SHORTEST` seconds the newest rate holds. A
    vehicle swings: its last rate alone would be off by its acceleration times the
    horizon, and the last sample is as noisy as any.

    A sample is a fault of the sensor, or of its bus, where a component is above both neighbours or
    below both by more than `SHAKEN` and than an angular acceleration of `SWIFTEST` explains: it
    counts as the nearer neighbour, their median. Of the newest sample one neighbour is missing:
    so far from the one before, it waits for the next, and a change of the rate that lasts is late
    by one sample.

    Parameters
    ----------
    hold : float
        Longest time, s, that this is done past the newest sample, and between two samples,
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
        capacity = max(2, int(DENSEST * memory))
        self._stamps = np.empty(capacity, np.int64)
        self._samples = np.empty((capacity, 3))  # as they came
        self._rates = np.empty((capacity, 3))  # without faults
        self._variances = np.empty(capacity)
        self._first = self._end = 0  # of what is kept
        self._waiting = 0  # newest samples, 0 or 1, that the next one may prove wrong

    @property
    def newest_ns(self) -> int | None:
        """Stamp of the newest sample that counts, ns; None where there is none."""
        newest = self._end - 1 - self._waiting
        return int(self._stamps[newest]) if newest >= self._first else None

    def reset(self) -> None:
        """Forget all samples."""
        self._first = self._end = self._waiting = 0

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
        check_stamp(stamp_ns)
        vector = np.asarray(rate, dtype=float)
        if vector.shape != (3,) or not np.abs(vector).max() <= FASTEST:
            raise TrackingError(
                f'the angular velocity is {vector.tolist()} rad/s; it must be 3 numbers within '
                f'+-{FASTEST:g}'
            )
        if not 0.0 <= variance <= FASTEST**2:
            raise TrackingError(
                f'the variance of the angular velocity is {variance} (rad/s)^2; it must be from 0 '
                f'to {FASTEST**2:g}'
            )
        place = self._place(stamp_ns)
        for kept, value in (
            (self._stamps, stamp_ns), (self._samples, vector), (self._rates, vector),
            (self._variances, variance),
        ):
            if place < self._end:
                kept[place + 1:self._end + 1] = kept[place:self._end].copy()
            kept[place] = value
        self._end += 1
        oldest = int(self._stamps[self._end - 1]) - self._memory_ns
        while self._stamps[self._first] < oldest:
            self._first += 1
        known = slice(self._first, self._end)
        self._waiting = _without_faults(
            self._stamps[known], self._samples[known], self._rates[known], place - self._first
        )

    def between(self, t0_ns: int, t1_ns: int) -> tuple[NDArray[np.float64], float]:
        """
        Return the base's rotation from one instant to a later one.

        Parameters
        ----------
        t0_ns, t1_ns : int
            ns of ROS time; up to `hold` past the newest sample.

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
        samples = slice(self._first, self._end - self._waiting)
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
        samples = slice(self._first, self._end - self._waiting)
        rate, gap = _rate(self._stamps[samples], self._rates[samples], stamp_ns, self._hold_ns)
        if gap:
            raise PlatformGap(self._reason(gap, stamp_ns, stamp_ns))
        return rate

    def _place(self, stamp_ns: int) -> int:
        """Return where a sample belongs, with room at the end."""
        capacity = len(self._stamps)
        if self._end == capacity:
            # Half of it is room again; the oldest go even where all are within the memory.
            first = max(self._first, capacity // 2)
            count = capacity - first
            for kept in (self._stamps, self._samples, self._rates, self._variances):
                kept[:count] = kept[first:]
            self._first, self._end = 0, count
        if self._end == self._first or stamp_ns > (newest := int(self._stamps[self._end - 1])):
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
def _leaps(stamps: NDArray[np.int64], samples: Array, index: int, axis: int) -> int:
    """Return whether the rate leaps up (1) or down (-1) from a sample to the next one, or 0."""
    step = samples[index + 1, axis] - samples[index, axis]
    if abs(step) <= SHAKEN + SWIFTEST * 1e-9 * (stamps[index + 1] - stamps[index]):
        return 0
    return 1 if step > 0.0 else -1


@kernel
def _without_faults(
    stamps: NDArray[np.int64], samples: Array, rates: Array, place: int
) -> int:
    """Fill the rates about a sample that has come; return 1 where the newest one must wait."""
    last = len(stamps) - 1
    for index in range(max(place - 1, 1), min(place + 2, last)):
        for k in range(3):
            rates[index, k] = samples[index, k]
            up = _leaps(stamps, samples, index - 1, k)
            if up != 0 and _leaps(stamps, samples, index, k) == -up:
                before, after = samples[index - 1, k], samples[index + 1, k]
                rates[index, k] = max(before, after) if up > 0 else min(before, after)
    if last == 0:
        return 0
    for k in range(3):
        if _leaps(stamps, samples, last - 1, k) != 0:
            return 1
    return 0


@kernel
def _line(
    stamps: NDArray[np.int64], rates: Array
) -> tuple[Array, Array, float, float, float]:
    """
    Return the rate at the newest sample, its slope, and their covariance for a noise of 1.

    The covariance is that of the weighted fit, A^-1 B A^-1 with A = X'WX and B = X'W^2X: of the
    rate, of both, and of the slope.
    """
    newest = len(stamps) - 1
    rate, slope = rates[newest].copy(), np.zeros(3)
    first = _search(stamps, stamps[newest] - round(1e9 * FITTED))
    span = 1e-9 * (stamps[newest] - stamps[first])
    if newest - first + 1 < FEWEST or span < SHORTEST:
        return rate, slope, 1.0, 0.0, 0.0
    a0 = a1 = a2 = b0 = b1 = b2 = 0.0
    sums, moments = np.zeros(3), np.zeros(3)
    for index in range(first, newest + 1):
        time = 1e-9 * (stamps[index] - stamps[newest])
        weight = 1.0 + time / FITTED
        a0 += weight
        a1 += weight * time
        a2 += weight * time * time
        b0 += weight * weight
        b1 += weight * weight * time
        b2 += weight * weight * time * time
        for k in range(3):
            sums[k] += weight * rates[index, k]
            moments[k] += weight * time * rates[index, k]
    determinant = a0 * a2 - a1 * a1
    for k in range(3):
        rate[k] = (a2 * sums[k] - a1 * moments[k]) / determinant
        slope[k] = (a0 * moments[k] - a1 * sums[k]) / determinant
    square = determinant * determinant
    return (
        rate, slope,
        (a2 * a2 * b0 - 2.0 * a1 * a2 * b1 + a1 * a1 * b2) / square,
        (-a1 * a2 * b0 + (a0 * a2 + a1 * a1) * b1 - a0 * a1 * b2) / square,
        (a1 * a1 * b0 - 2.0 * a0 * a1 * b1 + a0 * a0 * b2) / square,
    )


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
        rate, slope, _, _, _ = _line(stamps, rates)
        rate += 1e-9 * (stamp - stamps[before]) * slope
        return rate, 0
    if stamps[after] - stamps[before] > hold:
        return rate, BETWEEN
    share = (stamp - stamps[before]) / (stamps[after] - stamps[before])
    for k in range(3):
        rate[k] = rates[before, k] + share * (rates[after, k] - rates[before, k])
    return rate, 0


@kernel
def _turned(w0: Array, w1: Array, dt: float) -> Array:
    """Return how a vector at rest turns against the base while the rate goes from w0 to w1."""
    half, cone = 0.5 * dt, dt * dt / 12.0
    return from_vector(
        -half * (w0[0] + w1[0]) - cone * (w0[1] * w1[2] - w0[2] * w1[1]),
        -half * (w0[1] + w1[1]) - cone * (w0[2] * w1[0] - w0[0] * w1[2]),
        -half * (w0[2] + w1[2]) - cone * (w0[0] * w1[1] - w0[1] * w1[0]),
    )


@kernel
def _integrated(
    stamps: NDArray[np.int64], rates: Array, variances: Array, t0: int, t1: int, hold: int
) -> tuple[Array, float, int]:
    """Return the rotation, its variance, and where there is a gap."""
    turn = np.eye(3)
    count = len(stamps)
    variance = 0.0
    if count == 0 or t0 < stamps[0]:
        return turn, variance, BEFORE
    newest = stamps[count - 1]
    if t1 - newest > hold:
        return turn, variance, AFTER
    following = _search(stamps, t0)
    at = t0
    w0, gap = _rate(stamps, rates, t0, hold)
    if gap:  # also where no time passes: nobody knows the rate there
        return turn, variance, gap
    while at < t1 and following < count:
        if stamps[following] <= t1:
            until = stamps[following]
            w1 = rates[following]
            if until - stamps[following - 1] > hold:
                gap = BETWEEN
        else:
            until = t1
            w1, gap = _rate(stamps, rates, t1, hold)
        if gap:
            return turn, variance, gap
        dt = 1e-9 * (until - at)
        turn = product(_turned(w0, w1, dt), turn)
        # Each sample speaks for half the intervals beside it: its variance over its time
        # squared, shared out evenly over the interval so that parts add up to the whole.
        interval = 1e-9 * (stamps[following] - stamps[following - 1])
        variance += 0.5 * (variances[following - 1] + variances[following]) * interval * dt
        w0, at = w1, until
        following += 1
    if at < t1:
        rate, slope, of_rate, of_both, of_slope = _line(stamps, rates)
        begin, end = 1e-9 * (at - newest), 1e-9 * (t1 - newest)
        dt, half = end - begin, 0.5 * (end * end - begin * begin)
        turn = product(_turned(rate + begin * slope, rate + end * slope, dt), turn)
        variance += variances[count - 1] * (
            of_rate * dt * dt + 2.0 * of_both * dt * half + of_slope * half * half
        )
    return turn, variance, 0
