"""How much lights up by chance, and after how many flashes chance is ruled out."""

from __future__ import annotations

import math

from blob_tracker.segmentation.flash_track import FLANK_SIGMA, FOLLOWED_GATE_FRACTION

# False alarms: at most so many by chance in a frame, at the rate at which new things light up.
FALSE_ALARMS_PER_FRAME = 3e-6
CLUSTERING = 20.0  # times denser than if they were spread evenly: glints, leaves, a street's lamps
MOST_FLASHES = 6  # are always enough for what is clustered so: it leaves the rest of the frame
LEAST_CROWD = 2.0  # things a frame: fewer are none
BESIDE = 0.003  # of the frames: so often chance would pass for a target that is hidden
KNOWN_RUN = 4  # flashes without a miss, from which on a light is not one of those that pass
LEAST_MEMORY_FRAMES, MOST_MEMORY_FRAMES = 16, 128  # frames over which that rate is the mean
INITIAL_RATE = 0.05  # before anything was seen


class Crowd:
    """
    What lights up in a frame besides the target, as the mean over the last frames.

    Parameters
    ----------
    gate_px : float
        Greatest way of the target in the picture from one flash to the next, px.

    """

    def __init__(self, gate_px: float) -> None:
        self._gate_px = gate_px
        self._rate = INITIAL_RATE  # of new things that light up, a frame
        # Of all but what flashed several times, in even and in odd frames: what flashes in step is
        # in one kind of them alone, and no chance.
        self._passing = [INITIAL_RATE, INITIAL_RATE]
        self._passing_frames = [LEAST_MEMORY_FRAMES // 2, LEAST_MEMORY_FRAMES // 2]
        self._frames = LEAST_MEMORY_FRAMES

    def add(self, frame: float, new: int, passing: int) -> None:
        """
        Take what lit up in a whole frame.

        Parameters
        ----------
        frame : float
            Its number, counted by the stamps.
        new, passing : int
            New things, and all but those with KNOWN_RUN.

        """
        self._frames = min(self._frames + 1, MOST_MEMORY_FRAMES)
        self._rate += (new - self._rate) / self._frames
        self._add_passing(int(frame) % 2, passing)

    def add_part(self, passing: float, quiet: int) -> None:
        """
        Take what lit up between two flashes of the target.

        Parameters
        ----------
        passing : float
            As many as a whole frame would have.
        quiet : int
            Frames before this one in which there was nothing.

        """
        for _ in range(min(quiet, MOST_MEMORY_FRAMES)):
            self._add_passing(0, 0.0)
            self._add_passing(1, 0.0)
        self._add_passing(0, passing)
        self._add_passing(1, passing)

    def _add_passing(self, phase: int, passing: float) -> None:
        frames = min(self._passing_frames[phase] + 1, MOST_MEMORY_FRAMES // 2)
        self._passing_frames[phase] = frames
        self._passing[phase] += (passing - self._passing[phase]) / frames

    @property
    def passing(self) -> float:
        """How many things light up in a frame and do not flash."""
        return min(self._passing)

    def flashes_needed(self, shape: tuple[int, int]) -> int:
        """Return after how many flashes chance cannot have made a track in a frame of (h, w)."""
        rate = max(self._rate - 1.0 / self._frames, 0.0)  # the target was new once as well
        per_px2 = math.pi / (shape[0] * shape[1])
        first, later = self._gate_px**2, (FOLLOWED_GATE_FRACTION * self._gate_px) ** 2
        # Half of what lights up within reach is as bright as what lit up there before.
        return _flashes_beyond_chance(
            rate,
            0.5 * CLUSTERING * per_px2 * rate * first,
            0.5 * CLUSTERING * per_px2 * rate * later,
            MOST_FLASHES,
        )

    @property
    def is_crowd(self) -> bool:
        """Whether more than one or two things light up in a frame and do not flash."""
        return self.passing >= LEAST_CROWD

    def is_dense(self, shape: tuple[int, int], sigma: float) -> bool:
        """
        Tell whether a crowd lights up all over the frame, so that something is near anywhere.

        A light of such a sigma, px, would need more flashes than are always enough for what is
        clustered.
        """
        passing = self.passing
        per_px2 = math.pi / (shape[0] * shape[1])
        reach = FOLLOWED_GATE_FRACTION * self._gate_px + FLANK_SIGMA * sigma
        return _flashes_beyond_chance(
            passing, per_px2 * passing * self._gate_px**2, per_px2 * passing * reach**2,
            MOST_FLASHES + 1,
        ) > MOST_FLASHES

    def is_beside(self, shape: tuple[int, int], sigma: float) -> bool:
        """Tell whether something else is now and then where a target of such a sigma should be."""
        reach = FOLLOWED_GATE_FRACTION * self._gate_px + FLANK_SIGMA * sigma
        return self.passing * math.pi * reach**2 > BESIDE * shape[0] * shape[1]


def _flashes_beyond_chance(rate: float, first: float, later: float, most: int) -> int:
    """
    Return after how many flashes chance makes a track as seldom as it may.

    Parameters
    ----------
    rate : float
        New things that light up in a frame.
    first, later : float
        How many of them are within the gate of another one, and of a track whose motion is known.
    most : int
        Flashes that are always enough.

    """
    chance, flashes = rate * min(first, rate), 2
    while chance > FALSE_ALARMS_PER_FRAME and flashes < most:
        chance *= min(later, rate)
        flashes += 1
    return flashes
