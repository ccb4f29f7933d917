"""Bearings in, the target's direction at any instant out."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import replace
from math import isfinite, pi, sqrt
from typing import NamedTuple

from blob_tracker.kernel import Array
from blob_tracker.tracking.errors import check_stamp, PlatformGap, StampJump, TrackingError
from blob_tracker.tracking.kalman import Innovation, Seen, Step
from blob_tracker.tracking.models import MODELS
from blob_tracker.tracking.packed import (
    as_angles,
    largest_deviation,
    predicted,
    started,
    tracked,
    with_motion_forgotten,
    with_rates,
)
from blob_tracker.tracking.pan_tilt_angles import PanTiltAngles
from blob_tracker.tracking.platform_rates import PlatformRates
from blob_tracker.tracking.track import Track
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD
import numpy as np
from numpy.typing import NDArray

# Standard deviation of the rate at first sight, mrad/s: a vehicle that turns at 60 degrees a
# second, or a target that passes 30 m away at 30 m/s. The second bearing makes it forgotten.
FIRST_RATE = 1000.0
# Of the acceleration, mrad/s^2: that rate gained within a fifth of a second.
FIRST_ACCELERATION = 5000.0
# Bearings in a row that are a track: two give a rate, the third is the first that can contradict
# it. Of two, one of which is false, the rate is that of a leap within a frame.
AGREEING = 3
SUSPECTED = 2  # of them: one may be a false window, two that agree make the track doubtful
MEMORY_NS = 1_000_000_000  # for which late bearings are put in their place: a message's delay
ASYMMETRY = 1e-9  # of a covariance, of its standard deviations' product: rounding of a product
# Of a covariance's determinant, of its diagonal's product: a correlation that rounding can tell
# from a perfect one.
LEAST_DETERMINANT = 1e-12
# mrad^2, from 2 milliseconds of arc, which no camera sees, to half a turn, which says nothing.
LEAST_VARIANCE, MOST_VARIANCE = 1e-10, 1e7
STRAIGHT_UP = 0.5 * pi / MRAD  # mrad
AHEAD = np.eye(3)
NO_TURN = np.eye(3)


class Hypothesis(NamedTuple):
    """A packed state at an instant: of so many bearings, its rates the target's alone or not."""

    state: Array
    stamp_ns: int
    stabilised: bool
    bearings: int


class Situation(NamedTuple):
    """
    All that a bearing leaves behind.

    Parameters
    ----------
    track : Hypothesis or None
        Where the target is.
    rival : Hypothesis or None
        Where it may be instead: of bearings that the gate has refused.
    innovation : Innovation or None
        Of the bearing, against the track; None where there was none.
    refused : str
        Why it is not part of the track; empty where it is.
    unsure : float
        Deviation at which the track before ended, mrad, while the next is not yet told; 0 where
        none did.

    """

    track: Hypothesis | None = None
    rival: Hypothesis | None = None
    innovation: Innovation | None = None
    refused: str = ''
    unsure: float = 0.0


class Entry(NamedTuple):
    """A bearing, how the camera stood, and what it left behind."""

    seen: Seen
    stamp_ns: int
    after: Situation


class Tracker:
    """
    Follow one target through its bearings and tell its direction at any instant.

    A Kalman filter on the sphere. The base is the frame that does not turn with a pan/tilt;
    without one it is the camera's optical frame. Where the platform's rotation is known, the state
    is that of the target alone, and the base turns under it.

    Parameters
    ----------
    model : str
        A key of MODELS: which derivative of the angles is white noise.
    acceleration : float
        Process noise of `constant_velocity`: standard deviation of the change of the rate within
        a second, mrad/s^2, above 0. Also what the platform may do beyond its last known rate.
    jerk : float
        Process noise of `constant_acceleration`: the same of the acceleration, mrad/s^3.
    stabilised_acceleration, stabilised_jerk : float
        The same of the target alone, where the platform's rotation is known.
    gate : float
        Largest innovation that is believed, in standard deviations (Mahalanobis distance). A true
        one is beyond it with the probability exp(-gate^2 / 2): chi-square with two degrees of
        freedom.
    coast : float
        Longest time after the last bearing for which the track goes on, s.
    max_sigma : float
        Largest standard deviation of a direction that is told, mrad. A track that is less sure of
        the next bearing ends: its gate would let anything in.
    platform : PlatformRates, optional
        Rotation of the base.
    pan_tilt : PanTiltAngles, optional
        How the camera is turned against the base.

    Attributes
    ----------
    reason : str
        Why the last question had no answer; empty where it had one.
    innovation : Innovation or None
        Of the last bearing; None where it began a track.
    platform_gap : str
        Why the platform's rotation was not used at the last bearing; empty where it was, or where
        there is no `platform`.
    bearings, refused, late, begun : int
        Bearings taken; refused by the gate; of those taken or refused, the ones out of order;
        tracks begun, also those after a leap.

    Raises
    ------
    TrackingError
        Where a parameter cannot be.

    """

    def __init__(
        self,
        model: str = 'constant_velocity',
        *,
        acceleration: float = 300.0,
        jerk: float = 7000.0,
        stabilised_acceleration: float = 30.0,
        stabilised_jerk: float = 100.0,
        gate: float = 5.0,
        coast: float = 0.5,
        max_sigma: float = 20.0,
        platform: PlatformRates | None = None,
        pan_tilt: PanTiltAngles | None = None,
    ) -> None:
        if model not in MODELS:
            raise TrackingError(f"no model '{model}'; there is {', '.join(MODELS)}")
        noises = {
            'acceleration': acceleration, 'jerk': jerk,
            'stabilised_acceleration': stabilised_acceleration,
            'stabilised_jerk': stabilised_jerk,
        }
        for name, value in noises.items():
            _check_positive(name, value)
        self.gate, self.coast, self.max_sigma = gate, coast, max_sigma
        self.set_limits(gate=gate, coast=coast, max_sigma=max_sigma)
        self.model = model
        self.platform = platform
        self.pan_tilt = pan_tilt
        self._size, noise = MODELS[model]
        self._density = noises[noise]**2
        self._stabilised_density = noises[f'stabilised_{noise}']**2
        self._platform_density = (MRAD * acceleration)**2  # rad^2/s^3
        self.bearings = self.refused = self.late = self.begun = 0
        self.reset()

    def set_limits(
        self,
        *,
        gate: float | None = None,
        coast: float | None = None,
        max_sigma: float | None = None,
    ) -> None:
        """
        Set what is believed and told from now on; the track stays.

        Parameters
        ----------
        gate, coast, max_sigma : float, optional
            As at the beginning; without one it stays.

        Raises
        ------
        TrackingError
            Where one of them cannot be; then none is set.

        """
        if max_sigma is not None:
            _check_positive('max_sigma', max_sigma)
        for name, value in (('gate', gate), ('coast', coast)):
            if value is not None and not value > 0.0:
                raise TrackingError(f'{name} is {value}; it must be above 0')
        self.gate = self.gate if gate is None else gate
        self.coast = self.coast if coast is None else coast
        self.max_sigma = self.max_sigma if max_sigma is None else max_sigma

    def reset(self) -> None:
        """Forget the target; what has been counted stays."""
        self._before = Situation()  # what the oldest entry was applied to
        self._entries: list[Entry] = []
        self._stamps: list[int] = []
        self.innovation: Innovation | None = None
        self.platform_gap = ''
        self.reason = 'no bearing has come'

    @property
    def stamp_ns(self) -> int | None:
        """Stamp of the newest bearing that is part of the track, ns; None without a track."""
        track = self._situation.track
        return None if track is None else track.stamp_ns

    def update(self, bearing: Bearing) -> Track:
        """
        Take a bearing.

        One that is late, by up to a second, is put in its place: the result is as in order. One
        that the gate refuses may be where the target has leapt to: it starts a second hypothesis,
        which replaces the track when three refused bearings in a row agree.

        Parameters
        ----------
        bearing : Bearing
            In the camera's optical frame.

        Returns
        -------
        Track
            In the base at the stamp of the newest bearing, filtered.

        Raises
        ------
        TrackingError
            Where the bearing or its stamp is none that can be, has the stamp of another, or is
            refused by the gate, or where the camera's direction at its stamp is not known; the
            track stays.
        StampJump
            Where its stamp is from before the memory: `reset` if the clock was set back.

        """
        stamp = bearing.stamp_ns
        check_stamp(stamp)
        place = self._place(stamp)
        entry = Entry(self._checked(bearing), stamp, Situation())
        late = place < len(self._entries)
        self._stamps.insert(place, stamp)
        self._entries.insert(place, entry)
        before = self._entries[place - 1].after if place else self._before
        for index in range(place, len(self._entries)):
            entry = self._entries[index]
            before = self._after(before, entry.seen, entry.stamp_ns)
            self._entries[index] = entry._replace(after=before)
        mine = self._entries[place].after
        self._forget()
        self.late += late
        self.innovation = mine.innovation
        if mine.refused:
            self.refused += 1
            raise TrackingError(mine.refused)
        self.bearings += 1
        self.begun += mine.innovation is None
        track = before.track
        assert track is not None  # there is one after any bearing
        return self._track(track.state, track.stamp_ns, AHEAD)

    def at(self, stamp_ns: int) -> Track | None:
        """
        Return the target's direction in the base at an instant.

        Parameters
        ----------
        stamp_ns : int
            ns of ROS time: of a bearing (filtered), or after it (predicted).

        Returns
        -------
        Track or None
            Its rates are those of the target alone where the platform's rotation is known. None
            where there is no track of three bearings, the last one is more than `coast` ago, the
            deviation is above `max_sigma`, or two bearings that agree contradict it; `reason`
            tells.

        """
        found = self._at(stamp_ns)
        return None if found is None else self._track(found.state, stamp_ns, AHEAD)

    def seen_at(self, stamp_ns: int) -> Track | None:
        """
        Return the target's direction as the camera sees it at an instant.

        Parameters
        ----------
        stamp_ns : int
            ns of ROS time.

        Returns
        -------
        Track or None
            In the camera's optical frame; its rates are those of the picture, of the target less
            those of the platform and of the pan/tilt; accelerations, of which nobody knows the
            platform's, are 0 and unsure then. None as in `at`, and where the pan/tilt's
            place is not known.

        """
        found = self._at(stamp_ns)
        if found is None:
            return None
        state, camera = found.state, AHEAD
        try:
            if found.stabilised and self.platform is not None:
                state = _with_rates(state, self.platform.rate_at(stamp_ns), -1.0)
            if self.pan_tilt is not None:
                camera = self.pan_tilt.at(stamp_ns)
                state = _with_rates(state, self.pan_tilt.rate_at(stamp_ns), -1.0)
        except PlatformGap as gap:
            self.reason = str(gap)
            return None
        return self._track(state, stamp_ns, camera)

    @property
    def _situation(self) -> Situation:
        return self._entries[-1].after if self._entries else self._before

    def _at(self, stamp_ns: int) -> Hypothesis | None:
        """Return the track at an instant by the bearings until then, or say why there is none."""
        place = bisect_right(self._stamps, stamp_ns)
        track, rival, _, _, unsure = self._entries[place - 1].after if place else self._before
        if track is None or stamp_ns < track.stamp_ns:
            self.reason = 'no bearing has come' if not self._entries else (
                f'the instant is {1e-9 * (self._stamps[0] - stamp_ns):.3f} s before the oldest '
                'bearing that is kept'
            )
            return None
        age = 1e-9 * (stamp_ns - track.stamp_ns)
        if age > self.coast:
            self.reason = f'the last bearing is {age:.3f} s ago; coast is {self.coast:g} s'
            return None
        if rival is not None and rival.bearings >= SUSPECTED:
            self.reason = (
                f'the last {rival.bearings} bearings agree with each other and not with the track'
            )
            return None
        if track.bearings < AGREEING:
            self.reason = (
                f'only {track.bearings} of the {AGREEING} bearings that must agree have come'
            )
            if unsure:
                self.reason += (
                    f'; the track before was sure to {unsure:.1f} mrad when its next bearing '
                    f'came, max_sigma is {self.max_sigma:g}'
                )
            return None
        state, step, stabilised, _ = self._step(track, stamp_ns)
        found = Hypothesis(predicted(state, *step), stamp_ns, stabilised, track.bearings)
        sigma = largest_deviation(found.state)
        if not sigma <= self.max_sigma:
            self.reason = (
                f'the standard deviation of the direction is {sigma:.2f} mrad; max_sigma is '
                f'{self.max_sigma:g} mrad'
            )
            return None
        self.reason = ''
        return found

    def _place(self, stamp_ns: int) -> int:
        """Return the place of a new stamp in the memory."""
        stamps = self._stamps
        if not stamps or stamp_ns > stamps[-1]:
            return len(stamps)
        late = stamps[-1] - stamp_ns
        if late > MEMORY_NS:
            raise StampJump(
                f'the stamp is {1e-9 * late:.3f} s before the newest one; a bearing can be '
                f'{1e-9 * MEMORY_NS:g} s late (was the clock set back?)'
            )
        place = bisect_left(stamps, stamp_ns)
        if stamps[place] == stamp_ns:
            raise TrackingError(f'there is a bearing with the stamp {stamp_ns} ns')
        return place

    def _checked(self, bearing: Bearing) -> Seen:
        """Return the bearing as the kernels take it, or raise TrackingError."""
        azimuth, elevation = float(bearing.azimuth), float(bearing.elevation)
        if not (isfinite(azimuth) and abs(elevation) <= STRAIGHT_UP):
            raise TrackingError(
                f'azimuth and elevation are {azimuth:g} and {elevation:g} mrad; they must be '
                f'finite, the elevation within +-{STRAIGHT_UP:.1f}'
            )
        given = np.asarray(bearing.covariance, dtype=float)
        if given.shape != (2, 2):
            raise TrackingError(f"the bearing's covariance is {given.shape}; it must be (2, 2)")
        (a, b), (other, c) = given.tolist()
        # NaN and infinity pass no comparison that they must.
        if not (
            LEAST_VARIANCE <= a <= MOST_VARIANCE and LEAST_VARIANCE <= c <= MOST_VARIANCE
            and abs(b - other) <= ASYMMETRY * sqrt(a * c)
            and a * c - b * b > LEAST_DETERMINANT * a * c
        ):
            raise TrackingError(
                f"the bearing's covariance is {given.tolist()} mrad^2; it must be symmetric and "
                f'positive definite, each variance from {LEAST_VARIANCE:g} to {MOST_VARIANCE:g}'
            )
        camera = AHEAD
        if self.pan_tilt is not None:
            try:
                camera = self.pan_tilt.at(bearing.stamp_ns)
            except PlatformGap as gap:
                raise TrackingError(f'the bearing has no direction in the base: {gap}') from None
            of_joints = self.pan_tilt.variance_at(bearing.stamp_ns) / MRAD**2
            a, c = a + of_joints, c + of_joints
        return Seen(azimuth, elevation, a, b, c, camera)

    def _after(self, before: Situation, seen: Seen, stamp_ns: int) -> Situation:
        """Return the situation after a bearing."""
        track, rival = before.track, before.rival
        unsure = 0.0 if track is not None and track.bearings >= AGREEING else before.unsure
        if track is not None and self._lapsed(track, stamp_ns):
            track = None
        if rival is not None and self._lapsed(rival, stamp_ns):
            rival = None
        against = None
        if track is not None:
            found, against, sigma = self._tracked(track, seen, stamp_ns)
            # Of fewer bearings a track is not sure of anything, and learns it by the next one.
            if track.bearings >= AGREEING and not sigma <= self.max_sigma:
                track, unsure = None, sigma
            elif found is not None:
                return Situation(found, None, against, unsure=unsure)
        if rival is not None:
            found, _, _ = self._tracked(rival, seen, stamp_ns)
            if found is not None:
                if track is None or found.bearings >= AGREEING:
                    return Situation(found, unsure=unsure)
                rival = found
            else:
                rival = None
        if rival is None:
            rival = self._started(seen, stamp_ns)
        if track is None:
            return Situation(rival, unsure=unsure)
        assert against is not None  # of the track that refused it
        return Situation(
            track, rival, against,
            f'the bearing is {against.squared**0.5:.1f} standard deviations from where the track '
            f'expects it; gate is {self.gate:g}',
        )

    def _lapsed(self, track: Hypothesis, stamp_ns: int) -> bool:
        return 1e-9 * (stamp_ns - track.stamp_ns) > self.coast

    def _started(self, seen: Seen, stamp_ns: int) -> Hypothesis:
        """Return what a first bearing tells."""
        stabilised = False
        if self.platform is not None:
            try:
                self.platform.rate_at(stamp_ns)
                stabilised, self.platform_gap = True, ''
            except PlatformGap as gap:
                self.platform_gap = str(gap)
        state = started(*seen, FIRST_RATE, FIRST_ACCELERATION, self._size)
        return Hypothesis(state, stamp_ns, stabilised, 1)

    def _tracked(
        self, track: Hypothesis, seen: Seen, stamp_ns: int
    ) -> tuple[Hypothesis | None, Innovation, float]:
        """
        Return the track with a bearing, None where the gate refuses it.

        Then the innovation, and how sure the direction was before, mrad.
        """
        state, step, stabilised, self.platform_gap = self._step(track, stamp_ns)
        azimuth, elevation, rr, ru, uu, camera = seen
        passed, state, first, second, log_determinant, sigma = tracked(
            state, self.gate * self.gate, *step, azimuth, elevation, rr, ru, uu, camera
        )
        innovation = Innovation(first, second, log_determinant)
        if not passed:
            return None, innovation, sigma
        return Hypothesis(state, stamp_ns, stabilised, track.bearings + 1), innovation, sigma

    def _step(self, track: Hypothesis, stamp_ns: int) -> tuple[Array, Step, bool, str]:
        """
        Return the state to predict from and the step to an instant.

        Then whether the platform's rotation is in it, and why not where it should be.
        """
        seconds = 1e-9 * (stamp_ns - track.stamp_ns)
        if self.platform is None:
            return track.state, Step(seconds, self._density, NO_TURN, 0.0), False, ''
        try:
            turn, variance = self.platform.between(track.stamp_ns, stamp_ns)
            state = track.state
            if not track.stabilised:
                state = _with_rates(state, self.platform.rate_at(track.stamp_ns), 1.0)
        except PlatformGap as gap:
            state = self._unstabilised(track) if track.stabilised else track.state
            return state, Step(seconds, self._density, NO_TURN, 0.0), False, str(gap)
        variance += self._beyond(track.stamp_ns, stamp_ns)
        step = Step(seconds, self._stabilised_density, turn, variance / MRAD**2)
        return state, step, True, ''

    def _beyond(self, t0_ns: int, t1_ns: int) -> float:
        """
        Return the variance of the rotation past the newest rate, rad^2.

        The platform's acceleration is white noise of density q: after s seconds its rate is off
        by q s, and over the next t seconds its angle by q s t^2 + q t^3 / 3.
        """
        assert self.platform is not None and self.platform.newest_ns is not None
        newest = self.platform.newest_ns
        if t1_ns <= newest:
            return 0.0
        stale = 1e-9 * max(0, t0_ns - newest)
        seconds = 1e-9 * (t1_ns - max(t0_ns, newest))
        return self._platform_density * (stale + seconds / 3.0) * seconds**2

    def _unstabilised(self, track: Hypothesis) -> Array:
        """Return the state with the rates that the platform's rotation leaves of them."""
        assert self.platform is not None
        try:
            return _with_rates(track.state, self.platform.rate_at(track.stamp_ns), -1.0)
        except PlatformGap:
            # Nobody knows how the base turned.
            return with_motion_forgotten(track.state, FIRST_RATE, FIRST_ACCELERATION)

    def _forget(self) -> None:
        """Drop the bearings before which no late one can come."""
        count = bisect_left(self._stamps, self._stamps[-1] - MEMORY_NS)
        if count:
            self._before = self._entries[count - 1].after
            del self._entries[:count], self._stamps[:count]

    @staticmethod
    def _track(state: Array, stamp_ns: int, frame: NDArray[np.float64]) -> Track:
        return Track(stamp_ns, *as_angles(state, frame))


def _check_positive(name: str, value: float) -> None:
    if not (value > 0.0 and isfinite(value)):
        raise TrackingError(f'{name} is {value}; it must be above 0 and finite')


def _with_rates(state: Array, rotation: Array, sign: float) -> Array:
    """Return a state with the rates of a frame; its accelerations are as at first sight."""
    return with_rates(state, rotation, sign, FIRST_ACCELERATION)


def compile_ahead() -> None:
    """Compile the filter's loops, or load them from Numba's cache, before they are needed."""
    for model in MODELS:
        platform, pan_tilt = PlatformRates(), PanTiltAngles()
        tracker = Tracker(model, platform=platform, pan_tilt=pan_tilt)
        first = Bearing(0.0, 0.0, np.eye(2))
        for stamp in range(0, 10_000_000 * AGREEING, 10_000_000):
            platform.push(stamp, np.zeros(3))
            pan_tilt.push(stamp, 0.0, 0.0)
            tracker.update(replace(first, stamp_ns=stamp))
        tracker.at(30_000_000)
        tracker.seen_at(30_000_000)
        platform.reset()  # the rates that it leaves
        tracker.at(30_000_000)
