"""The platform's own rotation, from a gyro's angular velocity."""

from __future__ import annotations

from blob_tracker.tracking.angular_velocity import AFTER, BEFORE, rate_at, turn_between
from blob_tracker.tracking.errors import PlatformGap, StampJump, TrackingError
from blob_tracker.tracking.gyro_faults import without_faults
from blob_tracker.tracking.validation import check_positive, check_stamp
import numpy as np
from numpy.typing import ArrayLike, NDArray

DENSEST_HZ = 4000  # of samples in the memory: twice as fast as a fused gyro publishes
FASTEST_RAD_S = 100.0  # 6000 degrees a second, past the range of any gyro


class PlatformRates:
    """
    The rotation of the base between two instants, by its angular velocity.

    Between samples the angular velocity is linear in time. Over such an interval the turn is the
    exact one about the rotation vector

        (w0 + w1) dt / 2 + dt^2 / 12 (w0 x w1)

    whose second term is what the axis' own turning adds (Magnus expansion, fourth order; R. A.
    McKern, A Study of Transformation Algorithms, MIT 1968, calls it coning).

    Past the newest sample the angular velocity goes on along a straight line, the least-squares
    fit to the samples of the last `FITTED_S` seconds, whose weights rise evenly from 0 to 1 at the
    newest; of fewer than `FEWEST` or within less than `SHORTEST_S` seconds the newest rate holds.
    A vehicle swings: its last rate alone would be off by its acceleration times the horizon, and
    the last sample is as noisy as any.

    A sample is a fault of the sensor, or of its bus, where a component is above both neighbours or
    below both by more than `SHAKEN_RAD_S` and than an angular acceleration of `SWIFTEST_RAD_S2`
    explains: it counts as the nearer neighbour, their median. Of the newest sample one neighbour
    is missing: so far from the one before, it waits for the next, and a change of the rate that
    lasts is late by one sample.

    Parameters
    ----------
    hold : float
        Longest time, s, that this is done past the newest sample, and between two samples,
        beyond which the rotation counts as unknown.
    memory : float
        Time for which samples are kept, s; a late one within it is put in its place.

    Attributes
    ----------
    distrusted : str
        Why the samples are not to be used; empty if they are. Each instant is a gap then.

    Raises
    ------
    TrackingError
        If one of them is not above 0 and finite.

    Examples
    --------
    On a base that turns to the right, about y, at 0.1 rad/s, what was straight ahead half a second
    ago is 50 mrad to the left:

    >>> platform = PlatformRates()
    >>> for stamp_ns in range(0, 1_000_000_000, 10_000_000):
    ...     platform.push(stamp_ns, [0.0, 0.1, 0.0])
    >>> turn, _ = platform.between(200_000_000, 700_000_000)
    >>> x, _, z = turn @ [0.0, 0.0, 1.0]
    >>> round(1e3 * float(np.arctan2(x, z)), 1)  # mrad
    -50.0

    """

    def __init__(self, hold: float = 0.2, memory: float = 2.0) -> None:
        check_positive({'hold': hold, 'memory': memory}, ' s')
        self.hold = hold
        self.memory = memory
        self.distrusted = ''
        self._hold_ns, self._memory_ns = round(1e9 * hold), round(1e9 * memory)
        capacity = max(2, int(DENSEST_HZ * memory))
        self._stamps = np.empty(capacity, np.int64)
        self._samples = np.empty((capacity, 3))  # as they came
        self._rates = np.empty((capacity, 3))  # without faults
        self._variances = np.empty(capacity)
        self._first = self._end = 0  # of what is kept
        self._waiting = 0  # newest samples, 0 or 1, that the next one may prove wrong

    @property
    def newest_ns(self) -> int | None:
        """Stamp of the newest sample that counts, ns; None if there is none."""
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
            If a number is none that can be, or there is a sample with this stamp.
        StampJump
            If the stamp is from before the memory.

        """
        check_stamp(stamp_ns)
        vector = np.asarray(rate, dtype=float)
        if vector.shape != (3,) or not np.abs(vector).max() <= FASTEST_RAD_S:
            raise TrackingError(
                f'the angular velocity is {vector.tolist()} rad/s; it must be 3 numbers within '
                f'+-{FASTEST_RAD_S:g}'
            )
        if not 0.0 <= variance <= FASTEST_RAD_S**2:
            raise TrackingError(
                f'the variance of the angular velocity is {variance} (rad/s)^2; it must be from 0 '
                f'to {FASTEST_RAD_S**2:g}'
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
        self._waiting = without_faults(
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
            If the samples do not cover the time, or are distrusted, with a reason.

        """
        samples = slice(self._first, self._end - self._waiting)
        turn, variance, gap = turn_between(
            self._stamps[samples], self._rates[samples], self._variances[samples], t0_ns, t1_ns,
            self._hold_ns,
        )
        if gap or self.distrusted:
            raise PlatformGap(self.distrusted or self._reason(gap, t0_ns, t1_ns))
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
        rate, gap = rate_at(self._stamps[samples], self._rates[samples], stamp_ns, self._hold_ns)
        if gap or self.distrusted:
            raise PlatformGap(self.distrusted or self._reason(gap, stamp_ns, stamp_ns))
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
