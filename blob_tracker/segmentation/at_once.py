"""A frame and the one before it, searched in one compiled call where nothing is odd."""

from __future__ import annotations

import math
from typing import NamedTuple

from blob_tracker.kernel import Array, exact_kernel, kernel
from blob_tracker.segmentation.contrast import ROUNDING_DN
from blob_tracker.segmentation.crowd import add, LEAST_CROWD, passing
from blob_tracker.segmentation.dead_pixels import cut_out
from blob_tracker.segmentation.description import FIELDS
from blob_tracker.segmentation.drift import light_at
from blob_tracker.segmentation.flash_track import (
    CANDIDATE_FIELDS, DOUBTED, FLASHES, lights_in, offset_of, reach_of, SEEN,
)
from blob_tracker.segmentation.flash_tracks import (
    CERTAIN_FLASHES, Counts, IS_TARGET, KNOWN, LOCKED, LOCKED_FRAMES, MAX_AGE_FRAMES, next_frame,
    NUMBER, region_about, see, STANDS_IN,
)
from blob_tracker.segmentation.flash_watch import exposure_of, mean_sigma, Memory, watch_flash
from blob_tracker.segmentation.flat_top import BELOW_SIGMA, highest
from blob_tracker.segmentation.frame_clock import (
    FRAME, in_step, INTERVAL, is_due, stamp_before, tick,
)
from blob_tracker.segmentation.peaks import measure_peaks
from blob_tracker.segmentation.rejection import NOTHING
from blob_tracker.segmentation.repeated_frames import changed_samples
from blob_tracker.segmentation.search import (
    EXPOSURE_JUMP, JUMP_GLARE, JUMP_NOISE_SIGMA, LARGEST_SIGMA_PX, LEAST_FLOOD_DN,
    peak_threshold, RELIGHTING_SIGMA, SMALLEST_REGION_PX,
)
from blob_tracker.segmentation.sigma_window import about
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

# What a frame turns out to be: one that takes more than this, known before and after its region
# is searched; one in which nothing lit up, nor should have; one in which something did that is not
# known to flash; and one that shows the light.
UNUSUAL, SEARCHED, QUIET, LIT_UP, SHOWS_IT = range(5)
SETTLED_FRAMES = 32  # of a lock, after which it is known whether it is in a crowd
# Other lights in step are looked for in the whole frame: in the first of so many frames of a lock,
# and from then on in a few frames of as many.
SURVEY_FRAMES, SURVEY_PART = 128, 8


class Asked(NamedTuple):
    """
    What is asked of a light and its window.

    Parameters
    ----------
    mask : (h, w) or (0, 0) array
        0 where it cannot be; empty if it may be anywhere.
    min_snr, gated_snr : float
        Least SNR in the matched filter, in the whole frame and about the place where it is
        expected.
    sigmas : float
        Half-width of its window, standard deviations.
    largest : int
        That at most, px.

    """

    mask: NDArray[np.uint8]
    min_snr: float
    gated_snr: float
    sigmas: float
    largest: int


class Watched(NamedTuple):
    """
    What was seen of a light before.

    Parameters
    ----------
    memory : tuple of arrays
        That of `FlashWatch`.
    place : (float, float)
        Where it was in its last flash, px; not read where none is followed.
    since, exposure : float
        Time since then, 0 where none is followed, and that for which a frame is exposed, 0 where
        nobody tells, s.

    """

    memory: Memory
    place: tuple[float, float]
    since: float
    exposure: float


class Shown(NamedTuple):
    """
    What a frame shows of a light that is followed, or looked for.

    Parameters
    ----------
    outcome : int
        What the frame turns out to be.
    noisy : bool
        Whether its pixels change from frame to frame.
    region, box : (int, int, int, int)
        What was searched, and the window of the light, see `Box`.
    levels : (float, float, float)
        Median and standard deviation of lit less unlit, and the greatest rise of a pixel, DN.
    table : (n, 23) array
        The light, or what lit up, see `measure_peaks`.
    lit, unlit : (h, w) arrays
        The window's pixels, DN.
    seen : tuple
        The fields of `Seen`; of a first flash only its place.
    top : (int, int, int)
        The window's highest value, see `FlatTop`.

    """

    outcome: int
    noisy: bool
    region: tuple[int, int, int, int]
    box: tuple[int, int, int, int]
    levels: tuple[float, float, float]
    table: Array
    lit: Pixels
    unlit: Pixels
    seen: tuple[float, float, float, float, float, float, float, int, bool]
    top: tuple[int, int, int]

    @property
    def shown(self) -> bool:
        """Whether it shows the light."""
        return self.outcome == SHOWS_IT


@kernel
def pair_at_once(
    lit: Pixels, unlit: Pixels, mask: NDArray[np.uint8],
    clock: Array, tracks: Array, counts: Counts, target: Array, expected: Array,
    companions: Array, crowd: Array,
    flashes: Array, known: Array, flash_count: Counts, against: Array, place_counts: Counts,
    places: Array, rows: Array, row_counts: Counts,
    times: tuple[float, float, float, float], before: tuple[float, float],
    limits: tuple[float, float, float, float], largest: int, saturation: int, alone: bool,
) -> tuple[
    int, bool, tuple[int, int, int, int], tuple[int, int, int, int], tuple[float, float, float],
    Array, Pixels, Pixels, tuple[float, float, float, float, float, float, float, int, bool],
    tuple[int, int, int],
]:
    """
    Take a frame and the one before it, where nothing is odd about either.

    It is what is done step by step to any frame, with the same numbers. Where a step would lead
    elsewhere, all that is remembered is left as it was.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        The frame and the one before it, DN.
    mask : (h, w) or (0, 0) array
        See `Asked`.
    clock, tracks, counts, target, expected, companions
        Those of `flash_tracks.take`.
    crowd : (6,) array
        See `Crowd`.
    flashes, known, flash_count, against, place_counts, places, rows, row_counts
        The memory of `FlashWatch`.
    times : (float, float, float, float)
        Stamp of the frame as the clock has it, ns; the same, the time since the last flash, and
        that of an exposure or 0, s.
    before : (float, float)
        Where the light was in the last flash, px.
    limits : (float, float, float, float)
        Greatest way of a light from one flash to the next, px, and `Asked.min_snr`, `gated_snr`
        and `sigmas`.
    largest, saturation : int
        See `Asked`; the DN at which a pixel is clipped.
    alone : bool
        See `flash_tracks.see`.

    Returns
    -------
    tuple
        The fields of `Shown`.

    """
    if counts[LOCKED] < 0:
        return _found_at_once(
            lit, unlit, mask, clock, tracks, counts, target, expected, companions, crowd,
            times[0], limits, largest, saturation, alone,
        )
    gate_px, _, min_snr, sigmas = limits
    height, width = lit.shape
    whole = 0, 0, width, height
    nothing = np.empty((0, FIELDS + 1)), lit[:0, :0].copy(), unlit[:0, :0].copy()
    unseen = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, False
    unusual = UNUSUAL, False, whole, whole, (0.0, 0.0, 0.0), *nothing, unseen, (0, 0, 0)
    if not _is_settled(tracks, counts, companions):
        return unusual
    changed, enough = changed_samples(lit, unlit, 1)
    stamp, stamp_s, since, exposure = times
    now = clock.copy()
    tick(now, stamp)
    track = tracks[0]
    if changed == 0 or track[SEEN] < stamp_before(now, MAX_AGE_FRAMES):
        return unusual
    due = is_due(now, track[SEEN])
    if due and not in_step(now, track[SEEN]):
        return unusual
    region = region_about(now, tracks, counts, expected, gate_px, height, width)
    across, down = region[2] - region[0], region[3] - region[1]
    if 2 * across * down >= lit.size or min(across, down) < SMALLEST_REGION_PX:
        return unusual
    table, _, change, level, noise, brightness, strongest = measure_peaks(
        lit, unlit, region, mask, ROUNDING_DN, peak_threshold(across * down), min_snr,
        LARGEST_SIGMA_PX, saturation, False, True,
    )
    found = level, noise, strongest
    searched = SEARCHED, False, region, region, found, *nothing, unseen, (0, 0, 0)
    jump = EXPOSURE_JUMP * brightness + JUMP_NOISE_SIGMA * noise + JUMP_GLARE * strongest
    if change > RELIGHTING_SIGMA * noise or abs(level) > jump or table.shape[0] != int(due):
        return searched
    if not due:
        clock[:] = now
        counts[LOCKED_FRAMES] += 1
        return QUIET, changed >= enough, region, region, found, *nothing, unseen, (0, 0, 0)
    light = table[0]
    if light[-1] != NOTHING or lit[int(light[10]), int(light[9])] >= saturation:
        return searched
    lights = np.ones((1, CANDIDATE_FIELDS + 1))
    lights[0, :-1] = light[:CANDIDATE_FIELDS]
    if offset_of(track, reach_of(track, now, expected, gate_px), lights_in(lights)[0]) == np.inf:
        return searched
    box = about(
        light[0], light[1], sigmas * light[2], sigmas * light[3], largest, width, height
    )
    if box[0] <= 0 or box[1] <= 0 or box[2] >= width or box[3] >= height:
        return searched
    clock[:] = now
    counts[LOCKED_FRAMES] += 1
    see(
        clock, tracks, counts, target, expected, companions, crowd, lights, gate_px,
        height * width, False,
    )
    interval = seconds(clock[INTERVAL])
    seen = watch_flash(
        flashes, known, flash_count, against, place_counts, places, rows, row_counts, lit, unlit,
        light[0], light[1], mean_sigma(light[4], light[5]), light[19], before,
        (stamp_s, since, interval, exposure_of(exposure, interval)),
    )
    above, below = cut_out(lit, unlit, *box, saturation, light[19])
    top = highest(above, saturation, int(math.ceil(BELOW_SIGMA * light[19])))
    return SHOWS_IT, changed >= enough, region, box, found, table, above, below, seen, top


@kernel
def _found_at_once(
    lit: Pixels, unlit: Pixels, mask: NDArray[np.uint8],
    clock: Array, tracks: Array, counts: Counts, target: Array, expected: Array,
    companions: Array, crowd: Array, stamp: float, limits: tuple[float, float, float, float],
    largest: int, saturation: int, alone: bool,
) -> tuple[
    int, bool, tuple[int, int, int, int], tuple[int, int, int, int], tuple[float, float, float],
    Array, Pixels, Pixels, tuple[float, float, float, float, float, float, float, int, bool],
    tuple[int, int, int],
]:
    """Take such a frame where no light is followed: nothing lights up in it, or one thing."""
    gate_px, min_snr, _, sigmas = limits
    height, width = lit.shape
    whole = 0, 0, width, height
    nothing = np.empty((0, FIELDS + 1)), lit[:0, :0].copy(), unlit[:0, :0].copy()
    unseen = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, False
    unusual = UNUSUAL, False, whole, whole, (0.0, 0.0, 0.0), *nothing, unseen, (0, 0, 0)
    # A crowd is not told in a frame with one light.
    if (
        companions.shape[0] > 0 or passing(crowd) >= LEAST_CROWD
        or min(width, height) < SMALLEST_REGION_PX
    ):
        return unusual
    changed, enough = changed_samples(lit, unlit, 1)
    if changed == 0:
        return unusual
    table, _, change, level, noise, brightness, strongest = measure_peaks(
        lit, unlit, whole, mask, ROUNDING_DN, peak_threshold(width * height), min_snr,
        LARGEST_SIGMA_PX, saturation, False, False,
    )
    found = level, noise, strongest
    searched = SEARCHED, False, whole, whole, found, *nothing, unseen, (0, 0, 0)
    jump = EXPOSURE_JUMP * brightness + JUMP_NOISE_SIGMA * noise + JUMP_GLARE * strongest
    if (
        change > RELIGHTING_SIGMA * noise or abs(level) > jump or level > LEAST_FLOOD_DN
        or table.shape[0] > 1
    ):
        return searched
    if table.shape[0] == 0:
        next_frame(clock, tracks, counts, target, stamp)
        add(crowd, clock[FRAME], 0, 0)
        return QUIET, changed >= enough, whole, whole, found, *nothing, unseen, (0, 0, 0)
    light = table[0]
    if light[-1] != NOTHING or lit[int(light[10]), int(light[9])] >= saturation:
        return searched
    box = about(
        light[0], light[1], sigmas * light[2], sigmas * light[3], largest, width, height
    )
    if box[0] <= 0 or box[1] <= 0 or box[2] >= width or box[3] >= height:
        return searched
    next_frame(clock, tracks, counts, target, stamp)
    lights = np.ones((1, CANDIDATE_FIELDS + 1))
    lights[0, :-1] = light[:CANDIDATE_FIELDS]
    _, best, _ = see(
        clock, tracks, counts, target, expected, companions, crowd, lights, gate_px,
        height * width, alone,
    )
    if best < 0:
        return (
            LIT_UP, changed >= enough, whole, whole, found, table, *nothing[1:], unseen, (0, 0, 0)
        )
    _, (x, y), _ = light_at(lit, light[0], light[1], mean_sigma(light[4], light[5]))
    above, below = cut_out(lit, unlit, *box, saturation, light[19])
    top = highest(above, saturation, int(math.ceil(BELOW_SIGMA * light[19])))
    seen = x, y, 0.0, 0.0, 0.0, 0.0, 0.0, 0, False
    return SHOWS_IT, changed >= enough, whole, box, found, table, above, below, seen, top


@kernel
def _is_settled(tracks: Array, counts: Counts, companions: Array) -> bool:
    """Tell whether nothing but the target is known, for so long that it need not be doubted."""
    frames = counts[LOCKED_FRAMES] + 1
    return (
        counts[NUMBER] == 1 and counts[LOCKED] == 0 and counts[KNOWN] == 1
        and counts[IS_TARGET] == 1 and counts[STANDS_IN] == 0 and companions.shape[0] == 0
        and tracks[0, FLASHES] >= CERTAIN_FLASHES and tracks[0, DOUBTED] == 0.0
        and frames > SETTLED_FRAMES and not is_survey(frames)
    )


@kernel
def is_survey(frames: int) -> bool:
    """Tell whether other lights in step are looked for in a frame of a lock, by its number."""
    return frames < SURVEY_FRAMES // 2 or frames % SURVEY_FRAMES < SURVEY_PART


@exact_kernel
def seconds(time_ns: float) -> float:
    """Return a time in s."""
    return time_ns / 1e9
