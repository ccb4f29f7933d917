"""Where a target may be, and what is believed after a bearing."""

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.kernel import Array
from blob_tracker.tracking.kalman import Innovation

# Standard deviation of the rate at first sight: a vehicle that turns at 60 degrees a second, or a
# target that passes 30 m away at 30 m/s. The second bearing makes it forgotten.
FIRST_RATE_MRAD_S = 1000.0
# Of the acceleration: that rate gained within a fifth of a second.
FIRST_ACCELERATION_MRAD_S2 = 5000.0
# Bearings in a row that confirm a track: two give a rate, the third is the first that can
# contradict it. Of two, one of which is false, the rate is that of a leap within a frame.
CONFIRMING = 3
SUSPECTED = 2  # of them: one may be a false window, two that agree make the track doubtful


class Hypothesis(NamedTuple):
    """
    Where a target is, by a row of bearings that agree.

    Parameters
    ----------
    state : array
        As `packed` has it, in the base.
    stamp_ns : int
        Of the last bearing in it, ns of ROS time.
    stabilised : bool
        Whether its rates are the target's alone, without those of the platform.
    bearings : int
        In it.

    """

    state: Array
    stamp_ns: int
    stabilised: bool
    bearings: int

    @property
    def confirmed(self) -> bool:
        """Whether enough bearings agree."""
        return self.bearings >= CONFIRMING


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
        Of the bearing, against the track; None if there was none.
    refused : str
        Why it is not part of the track; empty if it is.
    unsure : float
        Deviation at which the track before ended, mrad, while the next is not yet told; 0 where
        none did.
    platform_gap : str
        Why the platform's rotation was not used; empty if it was, or if there is none.

    """

    track: Hypothesis | None = None
    rival: Hypothesis | None = None
    innovation: Innovation | None = None
    refused: str = ''
    unsure: float = 0.0
    platform_gap: str = ''
