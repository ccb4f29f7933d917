"""Bearings in, the target's direction at any instant out."""

from __future__ import annotations

from blob_tracker.kernel import Array
from blob_tracker.tracking.errors import PlatformGap, TrackingError
from blob_tracker.tracking.hypothesis import Hypothesis, Situation
from blob_tracker.tracking.hypothesis_filter import HypothesisFilter
from blob_tracker.tracking.kalman import Innovation, Measurement
from blob_tracker.tracking.loss import lost, not_yet, unsure
from blob_tracker.tracking.measurement import measured
from blob_tracker.tracking.memory import Memory
from blob_tracker.tracking.models import MODELS
from blob_tracker.tracking.packed import as_angles
from blob_tracker.tracking.pan_tilt import PanTilt
from blob_tracker.tracking.platform_rates import PlatformRates
from blob_tracker.tracking.platform_step import as_seen, ProcessNoise
from blob_tracker.tracking.rotation import NO_TURN
from blob_tracker.tracking.track import Track
from blob_tracker.tracking.validation import check_limits, check_positive, check_stamp
from blob_tracker.types import Bearing
from blob_tracker.units import MRAD


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
    gate_sigma : float
        Largest innovation that is believed, in standard deviations (Mahalanobis distance). A true
        one is beyond it with the probability exp(-gate_sigma^2 / 2): chi-square with two degrees
        of freedom.
    coast : float
        Longest time after the last bearing for which the track goes on, s.
    max_sigma : float
        Largest standard deviation of a direction that is told, mrad. A track that is less sure of
        the next bearing ends: its gate would let anything in.
    platform : PlatformRates, optional
        Rotation of the base.
    pan_tilt : PanTilt, optional
        How the camera is turned against the base.

    Attributes
    ----------
    reason : str
        Why the last question had no answer; empty if it had one.
    innovation : Innovation or None
        Of the last bearing; None if it began a track.
    bearings, refused, late, begun : int
        Bearings taken; refused by the gate; of those taken or refused, the ones out of order;
        tracks begun, also those after a leap.

    Raises
    ------
    TrackingError
        If a parameter is invalid.

    Examples
    --------
    A light that goes to the right at 50 mrad/s, and where it is a frame after the last bearing:

    >>> import numpy as np
    >>> tracker = Tracker(acceleration=30.0)
    >>> for index in range(60):
    ...     stamp_ns = 16_666_667 * index
    ...     _ = tracker.update(Bearing(50e-9 * stamp_ns, 0.0, np.diag([1e-4, 1e-4]), stamp_ns))
    >>> ahead = tracker.at(stamp_ns + 16_666_667)
    >>> round(ahead.azimuth, 1), round(float(ahead.rate[0]), 1)  # mrad, mrad/s
    (50.0, 50.0)
    >>> tracker.at(stamp_ns + 1_000_000_000), tracker.reason
    (None, 'the last bearing is 1.000 s ago; coast is 0.5 s')

    """

    def __init__(
        self,
        model: str = 'constant_velocity',
        *,
        acceleration: float = 300.0,
        jerk: float = 7000.0,
        stabilised_acceleration: float = 30.0,
        stabilised_jerk: float = 100.0,
        gate_sigma: float = 5.0,
        coast: float = 0.5,
        max_sigma: float = 20.0,
        platform: PlatformRates | None = None,
        pan_tilt: PanTilt | None = None,
    ) -> None:
        if model not in MODELS:
            raise TrackingError(f"no model '{model}'; there is {', '.join(MODELS)}")
        noises = {
            'acceleration': acceleration, 'jerk': jerk,
            'stabilised_acceleration': stabilised_acceleration,
            'stabilised_jerk': stabilised_jerk,
        }
        check_positive(noises)
        check_limits(gate_sigma, coast, max_sigma)
        self.gate_sigma, self.coast, self.max_sigma = gate_sigma, coast, max_sigma
        self.model, self.platform, self.pan_tilt = model, platform, pan_tilt
        size, noise = MODELS[model]
        densities = ProcessNoise(
            noises[noise]**2, noises[f'stabilised_{noise}']**2, (MRAD * acceleration)**2
        )
        self._filter = HypothesisFilter(size, densities, platform)
        self._memory = Memory(self._follow)
        self.bearings = self.refused = self.late = self.begun = 0
        self.reset()

    def set_limits(
        self,
        *,
        gate_sigma: float | None = None,
        coast: float | None = None,
        max_sigma: float | None = None,
    ) -> None:
        """
        Set what is believed and told from now on; the track stays.

        Parameters
        ----------
        gate_sigma, coast, max_sigma : float, optional
            As at the beginning; without one it stays.

        Raises
        ------
        TrackingError
            If one of them is invalid; then none is set.

        """
        gate_sigma = self.gate_sigma if gate_sigma is None else gate_sigma
        coast = self.coast if coast is None else coast
        max_sigma = self.max_sigma if max_sigma is None else max_sigma
        check_limits(gate_sigma, coast, max_sigma)
        self.gate_sigma, self.coast, self.max_sigma = gate_sigma, coast, max_sigma

    def reset(self) -> None:
        """Forget the target; what has been counted stays."""
        self._memory.clear()
        self.innovation: Innovation | None = None
        self.reason = 'no bearing has come'

    @property
    def stamp_ns(self) -> int | None:
        """Stamp of the newest bearing that is part of the track, ns; None without a track."""
        track = self._memory.newest.track
        return None if track is None else track.stamp_ns

    @property
    def platform_gap(self) -> str:
        """
        Why the platform's rotation was not used at the newest bearing.

        Empty where it was, or if there is no `platform`.
        """
        return self._memory.newest.platform_gap

    def update(self, bearing: Bearing) -> Track:
        """
        Take a bearing.

        One that is late, by up to a second, is put in its place: the result is as in order. One
        that the gate refuses may be where the target has jumped to: it starts a second hypothesis,
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
            If the bearing or its stamp is none that can be, has the stamp of another, or is
            refused by the gate, or where the camera's direction at its stamp is not known; the
            track stays.
        StampJump
            If its stamp is from before the memory: `reset` if the clock was set back.

        """
        check_stamp(bearing.stamp_ns)
        place = self._memory.place(bearing.stamp_ns)
        measurement = measured(bearing, self.pan_tilt)
        mine, late = self._memory.insert(place, measurement, bearing.stamp_ns)
        self.late += late
        self.innovation = mine.innovation
        if mine.refused:
            self.refused += 1
            raise TrackingError(mine.refused)
        self.bearings += 1
        self.begun += mine.innovation is None
        track = self._memory.newest.track
        assert track is not None  # there is one after any bearing
        return _told(track.state, track.stamp_ns, NO_TURN)

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
            if there is no track of three bearings, the last one is more than `coast` ago, the
            deviation is above `max_sigma`, or two bearings that agree contradict it; `reason`
            tells.

        """
        predicted = self._predict(stamp_ns)
        return None if predicted is None else _told(predicted.state, stamp_ns, NO_TURN)

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
        predicted = self._predict(stamp_ns)
        if predicted is None:
            return None
        try:
            state, camera = as_seen(predicted, self.platform, self.pan_tilt)
        except PlatformGap as gap:
            self.reason = str(gap)
            return None
        return _told(state, stamp_ns, camera)

    def _predict(self, stamp_ns: int) -> Hypothesis | None:
        """Return the track at an instant by the bearings until then, or say why there is none."""
        situation = self._memory.until(stamp_ns)
        track, predicted = situation.track, None
        if track is None or stamp_ns < track.stamp_ns:
            self.reason = not_yet(self._memory.oldest_ns, stamp_ns)
            return None
        self.reason = lost(track, situation, stamp_ns, self.coast, self.max_sigma)
        if not self.reason:
            predicted = self._filter.predict(track, stamp_ns)
            self.reason = unsure(predicted, self.max_sigma)
        return None if self.reason else predicted

    def _follow(self, before: Situation, measurement: Measurement, stamp_ns: int) -> Situation:
        """Delete what has ended, update what the gate lets a bearing into, or initiate."""
        track, rival = self._living(before.track, stamp_ns), self._living(before.rival, stamp_ns)
        doubt = before.unsure
        if before.track is not None and before.track.confirmed:
            doubt = 0.0
        if track is not None:
            found, innovation, sigma, gap = self._filter.update(
                track, measurement, stamp_ns, self.gate_sigma
            )
            # Of fewer bearings a track is not sure of anything, and learns it by the next one.
            if track.confirmed and not sigma <= self.max_sigma:
                track, doubt = None, sigma
            elif found is not None:
                return Situation(found, None, innovation, unsure=doubt, platform_gap=gap)
        if rival is not None:
            rival, _, _, gap = self._filter.update(rival, measurement, stamp_ns, self.gate_sigma)
            if rival is not None and (track is None or rival.confirmed):
                return Situation(rival, unsure=doubt, platform_gap=gap)
        if rival is None:
            rival, gap = self._filter.initiate(measurement, stamp_ns)
        if track is None:
            return Situation(rival, unsure=doubt, platform_gap=gap)
        refused = (
            f'the bearing is {innovation.squared**0.5:.1f} standard deviations from where the '
            f'track expects it; gate is {self.gate_sigma:g}'
        )
        return Situation(track, rival, innovation, refused, platform_gap=gap)

    def _living(self, hypothesis: Hypothesis | None, stamp_ns: int) -> Hypothesis | None:
        """Return a hypothesis unless it has had no bearing for too long."""
        if hypothesis is None or 1e-9 * (stamp_ns - hypothesis.stamp_ns) > self.coast:
            return None
        return hypothesis


def _told(state: Array, stamp_ns: int, frame: Array) -> Track:
    """Return a state as angles in a frame."""
    return Track(stamp_ns, *as_angles(state, frame))
