"""Pick out the light that flashes in step where things light up all over the frame."""

from __future__ import annotations

from collections.abc import Sequence
import math

from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.chance import (
    advance, BRIGHTNESS, FAMILY, FIELDS, FLASHES, FRAME, GAIN, KIND, KINDS, LIGHT, SCORE, SEEN,
    STEADY, VAR_V, VAR_X, VX, VY, X, Y,
)
from blob_tracker.segmentation.flash_track import FlashTrack
from blob_tracker.segmentation.frame_clock import PERIOD_FRAMES
import numpy as np
from numpy.typing import NDArray

FALSE_ALARMS_PER_FRAME = 3e-6  # confirmed by chance, at most
# Times as likely to flash in step as to flicker at one place in half of the frames, which is asked
# for: ten flashes, with nothing between them.
STEADIER = math.log(1e5)
# Above the bound of a target that is followed: one flash that is missed costs nothing, of several
# that are missed as many must come before it is believed again.
RESERVE = 2.0
# Of the flashes that are taken for a target's, those that are glints while it is hidden, at most.
# Of glints one in exp(g) adds g or more at most; as they are spread, one in ten of these.
ASTRAY, GLINTS_WITHIN = 1e-3, 0.1
LEAST_HIDDEN = 0.02  # of its flashes, at least: whatever was so far
SEEN_MEMORY = 20  # flashes over which it is counted how often the target is seen
CELL_PX, CELLS = 16, 3  # px; the density of glints is the mean over 48 px
LEAST_MEMORY_FRAMES, MOST_MEMORY_FRAMES = 8, 128  # over which it is the mean
WIDTH = 0.3  # e-folds, over which the density in brightness is the mean
EVEN = 0.2 / 3.0  # 1 / e-fold: a part of the glints are of any brightness over a range of 20
MOST_BRIGHTNESSES = 512  # of the last glints that are remembered
MOST_TRACKS = 2048  # the likeliest ones


class Glitter:
    """
    Follow all that might be the target among glints, and tell which one cannot be chance.

    See `chance.advance`. How many glints of which brightness are where is learned from the frames.

    Parameters
    ----------
    gate_px : float
        Greatest way of the target in the picture from one flash to the next, px.

    """

    def __init__(self, gate_px: float) -> None:
        self._gate_px = gate_px
        self._map = np.zeros((0, 0), np.float32)  # lights a frame in each cell
        self._mean = 0.0  # 1/px^2
        self._frames = 0
        self._brightnesses = np.empty(0)
        # Log-likelihood ratio of the target that is followed when it was last believed or missed
        self._before = 0.0
        self._hidden = False  # whether it was missed since it was last believed
        self._seen = SEEN  # part of the flashes in which the target that is followed is seen
        self.forget()

    def forget(self) -> None:
        """Begin anew; what is known of the glints is kept."""
        self._tracks = np.empty((0, FIELDS))
        self._earlier = np.empty((0, 7))

    @property
    def empty(self) -> bool:
        """Whether nothing is followed."""
        return len(self._tracks) == 0

    def begin_with(self, track: FlashTrack, frame: float, bound: float) -> None:
        """Follow one light that is known."""
        self.forget()
        self._tracks = np.zeros((len(KINDS), FIELDS))
        self._tracks[:, [X, Y, VX, VY]] = (
            track.x, track.y, PERIOD_FRAMES * track.velocity_x, PERIOD_FRAMES * track.velocity_y
        )
        # One flash of an even motion and the one before it, as in `chance`.
        self._tracks[:, VAR_X] = KINDS[:, 0] ** 2
        self._tracks[:, VAR_V] = KINDS[:, 0] ** 2 + KINDS[:, 1] ** 2
        self._tracks[:, BRIGHTNESS] = math.log(track.height)
        self._tracks[:, SCORE] = bound + RESERVE
        self._tracks[:, STEADY] = STEADIER
        self._tracks[:, [FRAME, LIGHT]] = frame, -1.0
        self._tracks[:, FLASHES] = track.flashes
        self._tracks[:, KIND] = np.arange(len(KINDS))
        self._seen, self._before, self._hidden = SEEN, bound + RESERVE, False

    def expect(self, frame: float, x: float, y: float, variance: float) -> None:
        """Take the word of a tracker for where the target is in a frame, px and px^2."""
        flashes = (frame - self._tracks[:, FRAME]) / PERIOD_FRAMES
        self._tracks[:, X] = x - flashes * self._tracks[:, VX]
        self._tracks[:, Y] = y - flashes * self._tracks[:, VY]
        self._tracks[:, VAR_X:VAR_V + 1] = variance, 0.0, 0.0

    def look(
        self,
        everything: Sequence[Candidate],
        frame: float,
        shape: tuple[int, int],
        *,
        followed: bool,
        density: float,
    ) -> None:
        """
        Take what lit up in the next frame.

        Parameters
        ----------
        everything : sequence of Candidate
            In the whole frame, or about the target that is followed.
        frame : float
            The frame's number, counted by the stamps.
        shape : (int, int)
            Its height and width, px.
        followed : bool
            Whether the target is followed: nothing else can be it.
        density : float
            Of what lights up beside it, 1/px^2.

        """
        lights = np.array([
            (
                each.x, each.y, (each.sigma_x**2 + each.sigma_y**2) / max(each.snr, 1.0) ** 2,
                math.log(max(each.height, 1e-3)), 0.0, not each.rejected,
            )
            for each in everything
        ]).reshape(-1, 6)
        if not followed:
            self._learn(lights, shape)
        else:
            self._mean = density
        lights[:, 4] = self._chance(lights)
        tracks = advance(self._tracks, self._earlier, lights, frame, self._gate_px)
        if len(tracks) > MOST_TRACKS:
            tracks = tracks[np.argpartition(-tracks[:, SCORE], MOST_TRACKS)[:MOST_TRACKS]]
        self._tracks = tracks
        if not followed:
            new = np.column_stack([lights, np.full(len(lights), frame)])[lights[:, 5] > 0.0]
            recent = self._earlier[self._earlier[:, 6] > frame - 2 * PERIOD_FRAMES]
            self._earlier = np.concatenate([recent, new])

    def best(self, frame: float, bound: float, *, followed: bool) -> tuple[int, FlashTrack] | None:
        """
        Return which of the lights of a frame is the target, and its track; None if none is.

        Parameters
        ----------
        frame : float
            The frame's number.
        bound : float
            Of the log-likelihood ratio, see `bound`.
        followed : bool
            Whether that target is followed already.

        """
        if self.empty:
            return None
        best = self._tracks[self._tracks[:, SCORE].argmax()]
        if not followed:
            found = self._steadiest(frame)
            if found is None:
                return None
            best = found
        gain, here = best[GAIN], best[FRAME] == frame
        hidden = max(1.0 - self._seen, LEAST_HIDDEN) / max(self._seen, LEAST_HIDDEN)
        if followed:
            # What hides it hides the next flash as well.
            hidden = max(hidden, 1.0) if self._hidden else hidden
            gain = best[SCORE] - self._before
            if int(frame - best[FRAME]) % PERIOD_FRAMES == 0:
                self._seen += (here - self._seen) / SEEN_MEMORY
                if not here:
                    self._before, self._hidden = float(best[SCORE]), True
        # What lights up between its flashes as well, time and again, is no target.
        steady = best[STEADY] > (0.0 if followed else STEADIER)
        likely = best[SCORE] >= bound and steady
        if not here or not likely or gain < math.log(GLINTS_WITHIN * hidden / ASTRAY):
            return None
        index = int(best[LIGHT])
        track = FlashTrack(
            float(best[X]), float(best[Y]), 0.0, math.exp(best[BRIGHTNESS]), 0.0,
            flashes=float(best[FLASHES]), run=float(best[FLASHES]),
            velocity_x=float(best[VX]) / PERIOD_FRAMES, velocity_y=float(best[VY]) / PERIOD_FRAMES,
        )
        return index, track

    def _steadiest(self, frame: float) -> NDArray[np.float64] | None:
        """
        Return the likeliest track of a light in this frame that does not flicker; None for none.

        One that left another track, which is likelier without it, has its likelihood from there.
        """
        tracks = self._tracks
        those = tracks[(tracks[:, STEADY] > STEADIER) & (tracks[:, FRAME] == frame)]
        for track in those[np.argsort(-those[:, SCORE])]:
            if track[SCORE] >= tracks[tracks[:, FAMILY] == track[FAMILY], SCORE].max():
                return np.asarray(track)
        return None

    def follow(self, frame: float, index: int, bound: float) -> None:
        """Follow this light of a frame alone from now on."""
        if len(self._earlier):
            self._seen = SEEN
        own = (self._tracks[:, FRAME] == frame) & (self._tracks[:, LIGHT] == index)
        self._tracks = self._tracks[own]
        self._tracks[:, SCORE] = np.minimum(self._tracks[:, SCORE], bound + RESERVE)
        self._tracks[:, STEADY] = np.minimum(self._tracks[:, STEADY], STEADIER)
        self._earlier = self._earlier[:0]
        self._before, self._hidden = float(self._tracks[:, SCORE].max()), False

    def _learn(self, lights: NDArray[np.float64], shape: tuple[int, int]) -> None:
        """Take the lights of a whole frame into the density of glints."""
        size = shape[0] // CELL_PX + 1, shape[1] // CELL_PX + 1
        if self._map.shape != size:
            self._map, self._frames = np.zeros(size, np.float32), 0
        allowed = lights[lights[:, 5] > 0.0]
        self._frames = min(self._frames + 1, MOST_MEMORY_FRAMES)
        part = 1.0 / max(self._frames, LEAST_MEMORY_FRAMES)
        if self._frames < LEAST_MEMORY_FRAMES:
            part = 1.0 / self._frames
        counts = np.zeros(size, np.float32)
        at = (np.maximum(allowed[:, :2], 0.0) / CELL_PX).astype(int)
        np.add.at(counts, (
            np.minimum(at[:, 1], size[0] - 1), np.minimum(at[:, 0], size[1] - 1)
        ), 1.0)
        self._map += part * (counts - self._map)
        self._mean += part * (len(allowed) / (shape[0] * shape[1]) - self._mean)
        self._brightnesses = np.concatenate(
            [self._brightnesses, allowed[:, 3]]
        )[-MOST_BRIGHTNESSES:]

    def _chance(self, lights: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the logarithm of the density of glints like each light, 1/px^2 and e-fold."""
        if self._map.size == 0 or len(self._brightnesses) == 0:
            return np.full(len(lights), math.log(self._mean + 1e-7))
        import cv2  # no part of a start

        local = cv2.blur(self._map, (CELLS, CELLS)) / CELL_PX**2
        at = (np.maximum(lights[:, :2], 0.0) / CELL_PX).astype(int)
        where = local[
            np.minimum(at[:, 1], local.shape[0] - 1), np.minimum(at[:, 0], local.shape[1] - 1)
        ]
        known = np.sort(self._brightnesses)
        # Of the fainter, the brighter and those on both sides the most: at the end of the glints'
        # range a mean over both sides is half of the truth, flash by flash.
        edges = [np.searchsorted(known, lights[:, 3] + k * WIDTH) for k in (-1.0, -0.5, 0.5, 1.0)]
        edges.insert(2, np.searchsorted(known, lights[:, 3]))
        within = np.max([edges[2] - edges[0], edges[3] - edges[1], edges[4] - edges[2]], axis=0)
        alike = EVEN + within / (WIDTH * len(known))
        return np.asarray(np.log(np.maximum(where, self._mean + 1e-7) * alike))


def bound(lights_a_frame: float) -> float:
    """Return the log-likelihood ratio that chance exceeds as seldom as it may."""
    return math.log(max(lights_a_frame, 1.0) / FALSE_ALARMS_PER_FRAME)
