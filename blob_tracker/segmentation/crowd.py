"""How much lights up by chance, and after how many flashes chance is ruled out."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.segmentation.flash_track import FLANK_SIGMA, FOLLOWED_GATE_FRACTION
import numpy as np

# False alarms: at most so many by chance in a frame, at the rate at which new things light up.
FALSE_ALARMS_PER_FRAME = 3e-6
CLUSTERING = 20.0  # times denser than if they were spread evenly: glints, leaves, a street's lamps
MOST_FLASHES = 6  # are always enough for what is clustered so: it leaves the rest of the frame
LEAST_CROWD = 2.0  # things a frame: fewer are none
BESIDE = 0.003  # of the frames: so often chance would pass for a target that is hidden
IN_PLACE = 0.01  # of the flashes that are hidden: so often chance may be taken for one
KNOWN_RUN = 4  # flashes without a miss, from which on a light is not one of those that pass
LEAST_MEMORY_FRAMES, MOST_MEMORY_FRAMES = 16, 128  # frames over which that rate is the mean
INITIAL_RATE = 0.05  # before anything was seen


# Places in a crowd: new things that light up, a frame, and over how many frames that is the mean;
# of all but what flashed several times, in even and in odd frames, the same. What flashes in step
# is in one kind of them alone, and no chance.
RATE, FRAMES, PASSING, PASSING_FRAMES = 0, 1, 2, 4


class Crowd:
    """
    What lights up in a frame besides the target, as the mean over the last frames.

    Parameters
    ----------
    gate_px : float
        Greatest way of the target in the picture from one flash to the next, px.

    Attributes
    ----------
    values : (6,) array
        What the kernels take: the places as above.

    """

    def __init__(self, gate_px: float) -> None:
        self._gate_px = gate_px
        memory = LEAST_MEMORY_FRAMES
        self.values = np.array([
            INITIAL_RATE, memory, INITIAL_RATE, INITIAL_RATE, memory // 2, memory // 2
        ])

    @property
    def passing(self) -> float:
        """How many things light up in a frame and do not flash."""
        return passing(self.values)

    def add(self, frame: float, count: int) -> None:
        """Take the number of a whole frame, and how many things, all of them new, lit up in it."""
        add(self.values, frame, count, count)

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
        add_part(self.values, passing, quiet)

    def is_dense(self, shape: tuple[int, int], sigma: float) -> bool:
        """Tell whether a crowd lights up all over a frame of (h, w), see the kernel."""
        return is_dense(self.values, self._gate_px, shape[0] * shape[1], sigma)

    def is_quiet(self, shape: tuple[int, int]) -> bool:
        """Tell whether what lights up within the gate of a target that is due is hardly chance."""
        # The start counts as things that nobody has seen.
        unseen = INITIAL_RATE * (LEAST_MEMORY_FRAMES // 2) / self.values[PASSING_FRAMES:].min()
        within = 0.5 * CLUSTERING * math.pi * self._gate_px**2 * (self.passing - unseen)
        return bool(within <= IN_PLACE * shape[0] * shape[1])

    def is_beside(self, shape: tuple[int, int], sigma: float) -> bool:
        """Tell whether something else is now and then where a target of such a sigma should be."""
        reach = FOLLOWED_GATE_FRACTION * self._gate_px + FLANK_SIGMA * sigma
        return self.passing * math.pi * reach**2 > BESIDE * shape[0] * shape[1]


@kernel
def add(crowd: Array, frame: float, new: int, others: int) -> None:
    """
    Take what lit up in a whole frame.

    Parameters
    ----------
    crowd : (6,) array
        See `Crowd`.
    frame : float
        Its number, counted by the stamps.
    new, others : int
        New things, and all but those with KNOWN_RUN.

    """
    crowd[FRAMES] = min(crowd[FRAMES] + 1.0, MOST_MEMORY_FRAMES)
    crowd[RATE] += (new - crowd[RATE]) / crowd[FRAMES]
    _add_passing(crowd, int(frame) % 2, others)


@kernel
def add_part(crowd: Array, others: float, quiet: int) -> None:
    """Take what lit up about the target, see `Crowd.add_part`."""
    for _ in range(min(quiet, MOST_MEMORY_FRAMES)):
        _add_passing(crowd, 0, 0.0)
        _add_passing(crowd, 1, 0.0)
    _add_passing(crowd, 0, others)
    _add_passing(crowd, 1, others)


@kernel
def _add_passing(crowd: Array, phase: int, others: float) -> None:
    frames = min(crowd[PASSING_FRAMES + phase] + 1.0, MOST_MEMORY_FRAMES // 2)
    crowd[PASSING_FRAMES + phase] = frames
    crowd[PASSING + phase] += (others - crowd[PASSING + phase]) / frames


@kernel
def passing(crowd: Array) -> float:
    """Return how many things light up in a frame and do not flash."""
    return min(crowd[PASSING], crowd[PASSING + 1])


@kernel
def flashes_needed(crowd: Array, gate_px: float, pixels: int) -> int:
    """Return after how many flashes chance cannot have made a track in a frame of such a size."""
    rate = max(crowd[RATE] - 1.0 / crowd[FRAMES], 0.0)  # the target was new once as well
    per_px2 = math.pi / pixels
    first, later = gate_px**2, (FOLLOWED_GATE_FRACTION * gate_px) ** 2
    # Half of what lights up within reach is as bright as what lit up there before.
    return _flashes_beyond_chance(
        rate,
        0.5 * CLUSTERING * per_px2 * rate * first,
        0.5 * CLUSTERING * per_px2 * rate * later,
        MOST_FLASHES,
    )


@kernel
def is_dense(crowd: Array, gate_px: float, pixels: int, sigma: float) -> bool:
    """
    Tell whether a crowd lights up all over the frame, so that something is near anywhere.

    More than one or two things light up and do not flash, and a light of such a sigma, px, would
    need more flashes than are always enough for what is clustered.
    """
    often = passing(crowd)
    if often < LEAST_CROWD:
        return False
    per_px2 = math.pi / pixels
    reach = FOLLOWED_GATE_FRACTION * gate_px + FLANK_SIGMA * sigma
    return _flashes_beyond_chance(
        often, per_px2 * often * gate_px**2, per_px2 * often * reach**2, MOST_FLASHES + 1
    ) > MOST_FLASHES


@kernel
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
