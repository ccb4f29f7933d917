"""Points of each frame in their order -> the lights with their names, places and times."""

from __future__ import annotations

from collections.abc import Sequence
import math
from typing import NamedTuple

from blob_tracker.blinking.association import step
from blob_tracker.blinking.children import Children, Room, Settings
from blob_tracker.blinking.exposure_watch import ExposureWatch
from blob_tracker.blinking.naming import best_rows, CLEAR, give_names
from blob_tracker.blinking.patterns import Pattern, tables
from blob_tracker.blinking.phase import fill_prior, OTHERS
from blob_tracker.blinking.tracks import (
    copy_row, empty_tracks, FLUX, FLUX_SIGMA, LEVELS, Tracks, Y,
)
from blob_tracker.kernel import Array, kernel
import numpy as np
from numpy.typing import NDArray

MOST_POINTS = 96  # of a frame, the brightest: a time a frame that is bounded
# Where points are left out a light's own may be among them, unless it is as many times as bright
OUT_OF_CROWD = 2.0
MOST_UNNAMED = 96  # rows without a name, the best
LEAST_CLUTTER = 0.3  # points a frame that are none of a light's, at least
CLUTTER_FRAMES = 30.0  # over which they are counted
FIRST_SPEED = 10.0  # px a frame interval, along each axis, of a light of which nothing is known
IN_STEP = 2e-3  # of the exposure: a light seen so near to its middle is in step with the frames
PACE_PART = 0.1  # of a frame's interval that is taken into their mean
LOST_S = 1.0  # s for which a light keeps its name unseen


class Lit(NamedTuple):
    """
    A light that a frame shows.

    Parameters
    ----------
    name : str
        The light.
    point : int
        Index of its point.
    x, y : float
        Filtered place at the middle of the exposure of its line, px.
    vx, vy : float
        Velocity, px/s.
    covariance : (6, 6) array
        Of x, y, velocity and acceleration, px and s.
    ax, ay : float
        Acceleration, px/s^2.
    share : float
        Part of the exposure for which it was on.
    tau, tau_sigma : float
        When it was seen, from the middle of the exposure, s: its place at that time is x + v tau.
    bend : (2, 2) array
        Covariance that a turn within the exposure may have brought to the place, px^2.

    Examples
    --------
    A light that is on in two frames of each five:

    >>> from blob_tracker.blinking import code
    >>> bits, point = '11000', [320.0, 240.0, 0.0025, 0.0, 0.0025, 1400.0, 5.0]
    >>> pattern = code('port', bits, 60.0, frames_per_bit=1)
    >>> tracker = BlinkTracker([pattern], interval=1 / 60, exposure=1 / 120, shape=(480, 640))
    >>> for index in range(52):
    ...     points = np.array([point] * int(bits[index % 5])).reshape(-1, 7)
    ...     lit = tracker.update(points, 16_666_667 * index, least_flux=100.0)
    >>> [(light.name, light.point, round(light.x), round(light.share)) for light in lit]
    [('port', 0, 320, 1)]

    """

    name: str
    point: int
    x: float
    y: float
    vx: float
    vy: float
    ax: float
    ay: float
    covariance: NDArray[np.float64]
    share: float
    tau: float
    tau_sigma: float
    bend: NDArray[np.float64]


class Known(NamedTuple):
    """
    A light with a name, in the last frame, seen or not.

    Parameters
    ----------
    name : str
        The light.
    x, y : float
        Filtered or predicted place, px.
    variance : float
        Of it, along one axis, px^2.
    flux : float
        Light that it should have had in the frame, DN px^2.

    Examples
    --------
    The standard deviation of its place along one axis, px:

    >>> light = Known('port', 320.0, 240.0, variance=0.01, flux=1400.0)
    >>> light.variance**0.5
    0.1

    """

    name: str
    x: float
    y: float
    variance: float
    flux: float


class BlinkTracker:
    """
    Follow lights that blink, each in a pattern of its own.

    Parameters
    ----------
    patterns : sequence of Pattern
        The lights.
    interval, exposure : float
        From frame to frame, and of a frame, s.
    shape : (int, int)
        Height and width of a frame, px.

    Attributes
    ----------
    crowded : bool
        Whether the last frame had more points than are looked at.

    Examples
    --------
    A still light that sends a bit in each frame; a row of points is x, y, their variances xx, xy
    and yy, the flux and its standard deviation:

    >>> from blob_tracker.blinking import code
    >>> bits, point = '1101011000', [320.0, 240.0, 0.0025, 0.0, 0.0025, 1400.0, 5.0]
    >>> pattern = code('port', bits, 60.0, frames_per_bit=1)
    >>> tracker = BlinkTracker([pattern], interval=1 / 60, exposure=1 / 120, shape=(480, 640))
    >>> for index in range(60):
    ...     points = np.array([point] * int(bits[index % 10])).reshape(-1, 7)
    ...     lit = tracker.update(points, 16_666_667 * index, least_flux=100.0)
    >>> len(lit), [(light.name, round(light.x)) for light in tracker.known()]
    (0, [('port', 320)])

    """

    def __init__(
        self, patterns: Sequence[Pattern], *, interval: float, exposure: float,
        shape: tuple[int, int],
    ) -> None:
        self.patterns = tuple(patterns)
        self.interval = interval
        self.exposure = min(exposure, interval)
        self._area = float(shape[0] * shape[1])
        self._tables = tables(patterns, interval, self.exposure)
        cells = int(self._tables.first[-1])
        self._prior = np.zeros(cells + OTHERS)
        fill_prior(self._tables.first, self._prior)
        rows = MOST_UNNAMED + MOST_POINTS + 4 * len(patterns)
        self._tracks, self._spare = empty_tracks(rows, cells), empty_tracks(rows, cells)
        born = 8 * rows
        self._children = Children(
            np.zeros(born, np.int64), np.zeros(born, np.int64), np.zeros(born, np.int64),
            np.zeros(born), np.zeros(born), np.zeros((born, 5)),
        )
        self._room = Room(
            np.zeros((6, 6)), np.zeros((4, LEVELS)), np.zeros(LEVELS), np.zeros(5),
            np.zeros(len(patterns), np.int64),
        )
        self._longest = max(each.longest_dark for each in patterns) / interval + 2.0
        self._keep = np.zeros(rows, np.bool_)
        self._best = np.zeros(len(patterns), np.int64)
        self._lead = np.zeros(len(patterns))
        self._count = 0
        self._clutter = 2.0
        self._numbers = 0
        self.crowded = False
        self._in_step = np.array([each.frames > 0 for each in patterns])
        scale = np.repeat([1.0, 1.0 / interval, 1.0 / interval**2], 2)
        self._units = np.outer(scale, scale)  # from frame intervals to s
        self._exposure_watch = ExposureWatch(self.patterns, interval, self.exposure)
        self._frames = 0
        self._pace = 1.0  # of the frames, in `interval`
        self._begun_ns: int | None = None
        self._last_ns = 0

    @property
    def exposure_ratio(self) -> float:
        """Return that of the exposure that the lights show to the told one: `ExposureWatch`."""
        return self._exposure_watch.ratio

    def update(
        self, points: Array, stamp_ns: int, least_flux: float, line_time: float = 0.0
    ) -> list[Lit]:
        """
        Take the points of the next frame.

        On a rolling shutter places are where the lights stood when their lines were exposed, and
        velocities what these move by from frame to frame: v / (1 - v_y line_time).

        Parameters
        ----------
        points : (n, 7) array
            x, y, and its variances xx, xy, yy, px; flux and its standard deviation, DN px^2.
        stamp_ns : int
            Middle of the exposure of the first line; later than that of the last frame.
        least_flux : float
            Flux of which half is seen.
        line_time : float
            From the exposure of a line to that of the next, s.

        Returns
        -------
        list of Lit
            The lights that have a point in this frame and a name that is sure.

        """
        if self._begun_ns is None:
            self._begun_ns = self._last_ns = stamp_ns
        clock = (stamp_ns - self._begun_ns) / (1e9 * self.interval)
        dt = (stamp_ns - self._last_ns) / (1e9 * self.interval)
        self._last_ns = stamp_ns
        # Frames are counted: between two of them there is a whole number, and one at least.
        if dt > 0.0:
            passed = max(round(dt / self._pace), 1)
            self._frames += passed
            self._pace += PACE_PART * (dt / passed - self._pace)
        clocks = np.where(self._in_step, self._frames, clock)  # of each pattern's light
        order = np.arange(len(points))
        self.crowded = len(points) > MOST_POINTS
        crowd = 0.0
        if self.crowded:
            order = np.argsort(-points[:, 5])[:MOST_POINTS]
            points = np.ascontiguousarray(points[order])
            crowd = float(np.median(points[:, 5]))
        settings = Settings(
            max(self._clutter, LEAST_CLUTTER) / self._area, least_flux, FIRST_SPEED,
            self._longest, LOST_S / self.interval, self.exposure / self.interval,
        )
        old, new = self._tracks, self._spare
        count, unclaimed = step(
            old, self._count, new, points, self._numbers, self._tables, self._prior, clocks,
            line_time / self.interval, clock, dt, settings, self._children, self._room,
            MOST_UNNAMED,
        )
        self._numbers += len(points)
        self._clutter += (unclaimed - self._clutter) / CLUTTER_FRAMES
        give_names(self._tables.first, self._prior, new, count, self._keep)
        self._count = _pack(new, count, self._keep)
        self._tracks, self._spare = new, old
        best_rows(self._tables.first, new, self._count, self._best, self._lead)
        self._watch_exposure(points, clocks, line_time / self.interval, least_flux)
        return [
            self._lit(name, int(row), order, points) for name, row in enumerate(self._best)
            if row >= 0 and new.now[row, 0] >= 0.0 and self._lead[name] > CLEAR
            and new.full[row, 0] > OUT_OF_CROWD * crowd
        ]

    def _watch_exposure(
        self, points: Array, clocks: Array, line: float, least_flux: float
    ) -> None:
        """Hold the exposure against one of the lights that are sure."""
        tracks, watch = self._tracks, self._exposure_watch
        if not watch.is_due():
            return
        sure = np.flatnonzero((self._best >= 0) & (self._lead > CLEAR))
        name = watch.whose_turn(sure.tolist())
        if name is None:
            return
        row = int(self._best[name])
        point = points[int(tracks.now[row, 0])] if tracks.now[row, 0] >= 0.0 else None
        y = tracks.state[row, 1] if point is None else point[Y]
        watch.add(
            name, float(clocks[name] + line * y),
            None if point is None else (float(point[FLUX]), float(point[FLUX_SIGMA])),
            tracks.full[row], least_flux,
        )

    def known(self) -> list[Known]:
        """Return the lights that have a name."""
        found = []
        for name, row in enumerate(self._best):
            if row >= 0:
                tracks = self._tracks
                state, covariance = tracks.state[row], tracks.covariance[row]
                found.append(Known(
                    self.patterns[name].name, float(state[0]), float(state[1]),
                    0.5 * float(covariance[0, 0] + covariance[1, 1]),
                    float(tracks.full[row, 0] * tracks.now[row, 3]),
                ))
        return found

    def _lit(self, name: int, row: int, order: NDArray[np.int64], points: Array) -> Lit:
        tracks, second = self._tracks, self.interval
        state, now = tracks.state[row], tracks.now[row]
        tau = float(now[1]) * second
        # By another exposure it was seen as much later, or earlier.
        dark = 1.0 - min(float(points[int(now[0]), FLUX] / tracks.full[row, 0]), 1.0)
        doubt = (self.exposure_ratio - 1.0) * max(abs(tau), 0.5 * dark * self.exposure)
        return Lit(
            self.patterns[name].name, int(order[int(now[0])]), float(state[0]), float(state[1]),
            float(state[2]) / second, float(state[3]) / second,
            float(state[4]) / second**2, float(state[5]) / second**2,
            tracks.covariance[row] * self._units, float(now[3]),
            0.0 if abs(tau) < IN_STEP * self.exposure else tau,
            math.hypot(math.sqrt(float(now[2])) * second, doubt),
            np.array([[now[6], now[7]], [now[7], now[8]]]),
        )


@kernel
def _pack(tracks: Tracks, count: int, keep: NDArray[np.bool_]) -> int:
    """Close the gaps that rows left which go no further; return how many are left."""
    filled = 0
    for row in range(count):
        if keep[row]:
            if row != filled:
                copy_row(tracks, row, tracks, filled)
            filled += 1
    return filled
