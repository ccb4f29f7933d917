"""The tracks of all that lights up: which lights go on with them, and which one is followed."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.segmentation.companions import companion_at
from blob_tracker.segmentation.crowd import (
    add, flashes_needed, is_dense, KNOWN_RUN, MOST_FLASHES,
)
from blob_tracker.segmentation.flash_track import (
    ALLOWED, DOUBTED, FIELDS, FLANK_SIGMA, FLASHES, gate_radius, HEIGHT, lights_in,
    MAX_BRIGHTNESS_RATIO, offset_of, place_of, reach_of, RUN, SEEN, SIGMA, SNR, TRUSTED, VX, VY, X,
    Y,
)
from blob_tracker.segmentation.frame_clock import (
    age_of, FRAME, in_step, is_complete, is_due, is_phase_unknown, PERIOD_FRAMES, STAMP,
    stamp_before, STAMP_TOLERANCE_FRAMES, tick,
)
import numpy as np
from numpy.typing import NDArray

Counts = NDArray[np.int64]

MAX_AGE_FRAMES = 8  # frames without a flash after which a track ends
MEMORY_FRAMES = 7200  # frames without it after which the target is forgotten
# What is kept of a crowd, the strongest of it, so that its frames take a bounded time. Each of the
# glints of a frame is on a track for 8 frames.
MOST_LIGHTS, MOST_TRACKS = 128, 512
MOST_SEEN = 512  # of a frame: those lights, and what else may be the target that is followed
REGION_MARGIN_PX = 16  # px about the prediction, and as many sigma as FLANK_SIGMA says
# Flashes of the target after which one that comes a frame late is still it
ESTABLISHED_FLASHES = 3
# Places in the counts: how many tracks there are; which is followed, -1 where none is, and from
# IN_SEEN on one of those that were seen in this frame and are not kept yet; for how many frames
# one is followed; whether the target is known, whether it is that one, and whether that one only
# stands in for it.
NUMBER, LOCKED, LOCKED_FRAMES, KNOWN, IS_TARGET, STANDS_IN = range(6)
IN_SEEN = MOST_TRACKS + MOST_SEEN
DOUBTED_FLASHES = 2  # more flashes are asked of a light that is doubted
CERTAIN_FLASHES = MOST_FLASHES + DOUBTED_FLASHES  # are always enough, also of such a light
# Columns of what was seen, after those of its track: which light it is, its SNR, and whether it
# has flashed often enough.
LIGHT, LIGHT_SNR, CONFIRMED = FIELDS, FIELDS + 1, FIELDS + 2
FEW_LIGHTS = 8  # in a frame, beyond which it may become a crowd
# What `see` leaves to be told: nothing; which of those that are confirmed is the target; and that
# of a crowd, which may be all over the frame.
TOLD, ASK, CROWDED, DENSE = range(4)
# What becomes of a track that a light belongs to: it stays and the light is another one, it ends,
# or the light goes on with it.
ANOTHER, ENDS, GOES_ON = range(3)


def no_tracks() -> tuple[Array, Counts]:
    """Return the table of tracks, one of `FlashTrack` a row, and its counts; of nothing seen."""
    counts = np.zeros(STANDS_IN + 1, np.int64)
    counts[LOCKED] = -1
    return np.empty((IN_SEEN, FIELDS)), counts


@kernel
def next_frame(
    clock: Array, tracks: Array, counts: Counts, target: Array, stamp: float
) -> bool:
    """
    Take the stamp of the next frame; what was not seen for too long ends.

    Returns whether the light that is followed is due in it.
    """
    tick(clock, stamp)
    oldest = stamp_before(clock, MAX_AGE_FRAMES)
    for k in range(counts[NUMBER]):
        if tracks[k, SEEN] < oldest:
            ended = np.zeros(counts[NUMBER], np.bool_)
            for other in range(k, counts[NUMBER]):
                ended[other] = tracks[other, SEEN] < oldest
            _end(tracks, counts, ended)
            break
    counts[LOCKED_FRAMES] = counts[LOCKED_FRAMES] + 1 if counts[LOCKED] >= 0 else 0
    if counts[KNOWN] and target[SEEN] < stamp_before(clock, MEMORY_FRAMES):
        counts[KNOWN], counts[IS_TARGET], counts[STANDS_IN] = 0, 0, 0
    return counts[LOCKED] >= 0 and is_due(clock, tracks[counts[LOCKED], SEEN])


@kernel
def _end(tracks: Array, counts: Counts, ended: NDArray[np.bool_]) -> None:
    """End tracks; where it is the one that is followed, none is from now on."""
    kept, locked = 0, counts[LOCKED]
    for k in range(counts[NUMBER]):
        if k == locked and ended[k]:
            counts[LOCKED], counts[IS_TARGET] = -1, 0
        if not ended[k]:
            if k == locked:
                counts[LOCKED] = kept
            if k > kept:
                tracks[kept] = tracks[k]
            kept += 1
    counts[NUMBER] = kept


@kernel
def half_side(clock: Array, track: Array, expected: Array, gate_px: float) -> float:
    """Return half the side of the region about the target that is followed, px."""
    if expected[2] >= 0.0:
        return REGION_MARGIN_PX + reach_of(track, clock, expected, gate_px)[2]
    half = REGION_MARGIN_PX + gate_radius(track, gate_px, PERIOD_FRAMES)
    age = age_of(clock, track[SEEN])
    missed = math.ceil(age / PERIOD_FRAMES - STAMP_TOLERANCE_FRAMES) - 1
    return half * 2.0 ** max(missed, 0)


@kernel
def region_about(
    clock: Array, tracks: Array, counts: Counts, expected: Array, gate_px: float, height: int,
    width: int,
) -> tuple[int, int, int, int]:
    """Return columns x0 to x1 and rows y0 to y1 of a frame in which the target can be."""
    locked = counts[LOCKED]
    if locked < 0 or tracks[locked, FLASHES] < 2.0:
        return 0, 0, width, height
    track = tracks[locked]
    half = half_side(clock, track, expected, gate_px)
    if 2.0 * half > min(height, width):
        return 0, 0, width, height
    x, y = place_of(track, clock, expected)
    column = int(min(max(np.rint(x), 0.0), width - 1.0))
    row = int(min(max(np.rint(y), 0.0), height - 1.0))
    side = int(np.rint(half))
    return (
        max(column - side, 0), max(row - side, 0),
        min(column + side + 1, width), min(row + side + 1, height),
    )


@kernel
def is_missed(
    clock: Array, track: Array, rows: Array, expected: Array, gate_px: float
) -> bool:
    """Tell whether a track's flash is due and nothing that lit up is it, see `rows_of`."""
    if not is_due(clock, track[SEEN]):
        return False
    reach, lights = reach_of(track, clock, expected, gate_px), lights_in(rows)
    for i in range(lights.shape[0]):
        if lights[i, ALLOWED] > 0.0 and offset_of(track, reach, lights[i]) < np.inf:
            return False
    return True


@kernel
def way_from_one_alike(
    clock: Array, tracks: Array, counts: Counts, x: float, y: float, height: float
) -> float:
    """Return how far a light is from where one like it flashed last, px; infinity from none."""
    away = np.inf
    for k in range(counts[NUMBER]):
        track = tracks[k]
        since = abs(age_of(clock, track[SEEN]) - PERIOD_FRAMES)
        ratio = height / track[HEIGHT]
        if since < STAMP_TOLERANCE_FRAMES and max(ratio, 1.0 / ratio) < MAX_BRIGHTNESS_RATIO:
            away = min(away, math.hypot(x - track[X], y - track[Y]))
    return away


@kernel
def take(
    clock: Array, tracks: Array, counts: Counts, target: Array, expected: Array, companions: Array,
    rows: Array, gate_px: float, survey: bool,
) -> Array:
    """
    Return the tracks of the strongest lights of a frame, brought up to date or new.

    A track goes on where something of like brightness lights up two frames later, by the stamps,
    within the gate; what lights up one or three frames later is out of step: a lamp on the mains.
    What goes on leaves the table, until `keep` puts it in again. A rejected light ends the tracks
    that it is out of step with.

    Parameters
    ----------
    clock, expected : (15,) and (3,) arrays
        See `flash_track.reach_of`.
    tracks, counts : (n, 11) and (6,) arrays
        See `no_tracks`.
    target : (11,) array
        As it was last seen.
    companions : (k, 3) array
        See `Companions`.
    rows : (m, 13) array
        What lit up, see `flash_track.rows_of`.
    gate_px : float
        Greatest way of a light from one flash to the next, px.
    survey : bool
        Whether these are other lights than that which is followed.

    Returns
    -------
    (s, 14) array
        Tracks, and of each the number of its light, its SNR, and whether it is confirmed.

    """
    number, locked = counts[NUMBER], counts[LOCKED]
    lights = lights_in(rows)
    may_go_on = np.zeros(number, np.bool_)
    ended = np.zeros(number, np.bool_)
    reaches = np.empty((number, 3))
    nowhere = np.full(3, -1.0)
    for k in range(number):
        if tracks[k, SEEN] != clock[STAMP] and not (survey and k == locked):
            may_go_on[k] = True
            reaches[k] = reach_of(
                tracks[k], clock, expected if k == locked else nowhere, gate_px
            )
    for i in range(lights.shape[0]):
        if lights[i, ALLOWED] == 0.0:
            _mark_out_of_step(clock, tracks, locked, reaches, may_go_on, ended, lights[i])
    chosen = _strongest(clock, tracks, locked, expected, lights, gate_px)
    partners = _partners(
        clock, tracks, counts, target, expected, companions, lights, chosen, reaches, may_go_on,
        gate_px,
    )
    seen = np.zeros((chosen.size, CONFIRMED + 1))
    following = -1
    for s in range(chosen.size):
        row, light, k = seen[s], lights[chosen[s]], partners[s]
        row[X], row[Y], row[SIGMA], row[HEIGHT] = light[X], light[Y], light[SIGMA], light[HEIGHT]
        row[SEEN], row[FLASHES], row[RUN] = clock[STAMP], 1.0, 1.0
        row[LIGHT], row[LIGHT_SNR] = chosen[s], light[SNR]
        if k < 0:
            continue
        going_on = _go_on(clock, tracks[k], row, k == locked)
        ended[k] = going_on != ANOTHER
        if k == locked and going_on == GOES_ON:
            following = s
    _end(tracks, counts, ended)
    if following >= 0:
        counts[LOCKED] = IN_SEEN + following
    return seen


@kernel
def _mark_out_of_step(
    clock: Array, tracks: Array, locked: int, reaches: Array, may_go_on: NDArray[np.bool_],
    ended: NDArray[np.bool_], light: Array,
) -> None:
    """Mark the young track that is followed, and end all others, where it is out of step."""
    for k in range(may_go_on.size):
        track = tracks[k]
        if (
            may_go_on[k]
            and math.hypot(light[X] - reaches[k, 0], light[Y] - reaches[k, 1])
            < FLANK_SIGMA * (track[SIGMA] + 1.0)
            and track[FLASHES] < MOST_FLASHES
            and not in_step(clock, track[SEEN])
            and track[HEIGHT] < MAX_BRIGHTNESS_RATIO * light[HEIGHT]
        ):
            track[DOUBTED] = 1.0
            if k != locked:
                may_go_on[k], ended[k] = False, True


@kernel
def _strongest(
    clock: Array, tracks: Array, locked: int, expected: Array, lights: Array, gate_px: float
) -> NDArray[np.int64]:
    """Return which lights are the highest of a crowd, or may be the target that is followed."""
    allowed = np.flatnonzero(lights[:, ALLOWED] > 0.0)
    if allowed.size <= MOST_LIGHTS:
        return allowed
    allowed = allowed[np.argsort(-lights[allowed, HEIGHT], kind='mergesort')]
    count = MOST_LIGHTS
    if locked >= 0:
        reach = reach_of(tracks[locked], clock, expected, gate_px)
        for i in allowed[MOST_LIGHTS:]:
            if count < MOST_SEEN and offset_of(tracks[locked], reach, lights[i]) < np.inf:
                allowed[count] = i
                count += 1
    return allowed[:count]


@kernel
def _partners(
    clock: Array, tracks: Array, counts: Counts, target: Array, expected: Array, companions: Array,
    lights: Array, chosen: NDArray[np.int64], reaches: Array, may_go_on: NDArray[np.bool_],
    gate_px: float,
) -> NDArray[np.int64]:
    """
    Return the tracks that lights belong to, -1 for none; the nearest pairs first.

    What flashes beside the target does not belong to its track.
    """
    locked = counts[LOCKED]
    partners = np.full(chosen.size, -1)
    most = chosen.size * np.count_nonzero(may_go_on)
    away, pairs = np.empty(most), np.empty((most, 2), np.int64)
    count = 0
    for s in range(chosen.size):
        light = lights[chosen[s]]
        for k in range(may_go_on.size):
            if not may_go_on[k]:
                continue
            reach = reaches[k, 0], reaches[k, 1], reaches[k, 2]
            offset = offset_of(tracks[k], reach, light)
            if offset == np.inf or (k == locked and _is_beside(
                clock, counts, target, expected, companions, light, gate_px
            )):
                continue
            away[count], pairs[count, 0], pairs[count, 1] = offset, s, k
            count += 1
    taken = np.zeros(may_go_on.size, np.bool_)
    for pair in np.argsort(away[:count], kind='mergesort'):
        s, k = pairs[pair]
        if partners[s] < 0 and not taken[k]:
            partners[s], taken[k] = k, True
    if chosen.size == 1 and locked < 0 and partners[0] < 0:
        partners[0] = _turned(clock, tracks, may_go_on, lights[chosen[0]], gate_px)
    return partners


@kernel
def _turned(
    clock: Array, tracks: Array, may_go_on: NDArray[np.bool_], light: Array, gate_px: float
) -> int:
    """
    Return the track whose light has turned and is the only one of a frame, -1 for none.

    It is near its last place, and not where its speed would have it; it is doubted from now on.
    """
    nearest, track = np.inf, -1
    for k in range(may_go_on.size):
        if may_go_on[k] and tracks[k, FLASHES] > 1.0 and in_step(clock, tracks[k, SEEN]):
            radius = FLANK_SIGMA * tracks[k, SIGMA] + gate_px
            offset = offset_of(tracks[k], (tracks[k, X], tracks[k, Y], radius), light)
            if offset < nearest:
                nearest, track = offset, k
    if track >= 0:
        tracks[track, DOUBTED] = 1.0
    return track


@kernel
def _is_beside(
    clock: Array, counts: Counts, target: Array, expected: Array, companions: Array, light: Array,
    gate_px: float,
) -> bool:
    """Tell whether a light is one of those that flash beside the target."""
    if companions.shape[0] == 0 or not counts[KNOWN] or counts[STANDS_IN]:
        return False
    return companion_at(
        companions, target, counts[IS_TARGET] == 1, clock, expected, light[X], light[Y],
        light[HEIGHT], gate_px,
    ) >= 0


@kernel
def _go_on(clock: Array, track: Array, row: Array, followed: bool) -> int:
    """Bring a track up to date by the light that belongs to it, in its new row."""
    age, phase_unknown = age_of(clock, track[SEEN]), is_phase_unknown(clock, track[SEEN])
    if not in_step(clock, track[SEEN]):
        if track[FLASHES] >= MOST_FLASHES and age < PERIOD_FRAMES:
            return ANOTHER  # right after a flash that was expected
        if followed and track[FLASHES] >= ESTABLISHED_FLASHES and age > PERIOD_FRAMES:
            # It missed its flash and comes a frame late: the light slipped.
            row[TRUSTED] = 1.0
            return GOES_ON
        row[DOUBTED] = 1.0
        return ENDS
    row[VX], row[VY] = (row[X] - track[X]) / age, (row[Y] - track[Y]) / age
    row[FLASHES] = track[FLASHES] + 1.0
    missed = np.rint(age) > PERIOD_FRAMES + phase_unknown
    row[RUN] = 1.0 if missed else track[RUN] + 1.0
    row[DOUBTED], row[TRUSTED] = track[DOUBTED], track[TRUSTED]
    if missed and track[FLASHES] == 1.0 and is_complete(clock, track[SEEN]):
        # No two flashes in a row yet: a light of another rhythm rises once in four frames or six.
        row[FLASHES], row[TRUSTED] = 1.0, 0.0
    return GOES_ON


@kernel
def see(
    clock: Array, tracks: Array, counts: Counts, target: Array, expected: Array, companions: Array,
    crowd: Array, rows: Array, gate_px: float, pixels: int, alone: bool,
) -> tuple[Array, int, int]:
    """
    Take the lights of a frame, and follow the target where it is among them.

    Parameters
    ----------
    clock, tracks, counts, target, expected, companions, rows, gate_px
        Those of `take`.
    crowd : (6,) array
        See `Crowd`.
    pixels : int
        Of the frame.
    alone : bool
        Whether nothing else speaks against a light that is the only one.

    Returns
    -------
    seen : (s, 14) array
        What `take` returns, with what is trusted and confirmed.
    best : int
        Which of these is the target, -1 for none.
    left : int
        TOLD; else it is still to be told, and `keep` to be called.

    """
    seen = take(
        clock, tracks, counts, target, expected, companions, rows, gate_px, False
    )
    left = confirm(clock, counts, crowd, seen, gate_px, pixels, alone)
    if left == TOLD and rows.shape[0] > FEW_LIGHTS and counts[LOCKED] < 0:
        left = CROWDED
    if left != TOLD or (companions.shape[0] > 0 and not _is_sure(counts, seen)):
        return seen, -1, max(left, ASK)
    best = _best_of(clock, tracks, counts, seen)
    keep(tracks, counts, target, seen, best)
    return seen, best, TOLD


@kernel
def confirm(
    clock: Array, counts: Counts, crowd: Array, seen: Array, gate_px: float, pixels: int,
    alone: bool,
) -> int:
    """
    Note which of the lights that `take` returned are trusted and confirmed; count the others.

    Returns TOLD, or DENSE where no target is followed and things light up all over the frame.
    """
    for s in range(seen.shape[0]):
        trusted = (seen[s, TRUSTED] > 0.0 or alone) and seen[s, DOUBTED] == 0.0
        seen[s, TRUSTED] = 1.0 if trusted else 0.0
    left = TOLD
    if counts[LOCKED] < 0:
        new, others, sigma = 0, 0, 0.0
        for s in range(seen.shape[0]):
            new += seen[s, FLASHES] == 1.0 and seen[s, DOUBTED] == 0.0
            others += seen[s, RUN] < KNOWN_RUN
            sigma = max(sigma, seen[s, SIGMA])
        add(crowd, clock[FRAME], new, others)
        left = DENSE if is_dense(crowd, gate_px, pixels, sigma) else TOLD
    needed = flashes_needed(crowd, gate_px, pixels)
    for s in range(seen.shape[0]):
        flashes = seen[s, FLASHES]
        seen[s, CONFIRMED] = 1.0 if (
            seen[s, TRUSTED] > 0.0 or flashes >= CERTAIN_FLASHES
            or flashes >= needed + DOUBTED_FLASHES * seen[s, DOUBTED]
        ) else 0.0
    return left


@kernel
def _is_sure(counts: Counts, seen: Array) -> bool:
    """Tell whether the light that is followed is among those seen, and confirmed."""
    s = counts[LOCKED] - IN_SEEN
    return s >= 0 and seen[s, CONFIRMED] > 0.0


@kernel
def is_open(clock: Array, tracks: Array, counts: Counts, seen: Array) -> bool:
    """Tell whether another light than the one that is followed may be the target."""
    locked = counts[LOCKED]
    if locked < 0:
        return True
    track = seen[locked - IN_SEEN] if locked >= IN_SEEN else tracks[locked]
    return track[FLASHES] < 2.0 or is_due(clock, track[SEEN])


@kernel
def _best_of(clock: Array, tracks: Array, counts: Counts, seen: Array) -> int:
    """Return which of the lights is the target: that which is followed, or has the highest SNR."""
    if _is_sure(counts, seen):
        return counts[LOCKED] - IN_SEEN
    best = -1
    if is_open(clock, tracks, counts, seen):
        for s in range(seen.shape[0]):
            if seen[s, CONFIRMED] > 0.0 and (
                best < 0 or seen[s, LIGHT_SNR] > seen[best, LIGHT_SNR]
            ):
                best = s
    return best


@kernel
def keep(tracks: Array, counts: Counts, target: Array, seen: Array, best: int) -> None:
    """
    Put the tracks of what was seen into the table, and follow one of them, or none for -1.

    What is followed is the target, or stands in for it. What is beyond the number of tracks that
    are kept is forgotten.
    """
    number = counts[NUMBER]
    if counts[LOCKED] >= IN_SEEN:
        counts[LOCKED] += number - IN_SEEN
    for s in range(seen.shape[0]):
        tracks[number + s] = seen[s, :FIELDS]
    counts[NUMBER] = number + seen.shape[0]
    if best >= 0:
        follow(tracks, counts, target, number + best)
    number = counts[NUMBER]
    if number > MOST_TRACKS:
        # By how often they flashed; of as many flashes the brightest.
        rank = tracks[:number, FLASHES] + 1e-6 * tracks[:number, HEIGHT]
        if counts[LOCKED] >= 0:
            rank[counts[LOCKED]] = np.inf
        ended = np.zeros(number, np.bool_)
        for k in np.argsort(-rank, kind='mergesort')[MOST_TRACKS:]:
            ended[k] = True
        _end(tracks, counts, ended)


@kernel
def follow(tracks: Array, counts: Counts, target: Array, k: int) -> None:
    """Follow a track of the table from this frame on; it is the target, or stands in for it."""
    counts[LOCKED], counts[IS_TARGET] = k, 0
    if not counts[STANDS_IN]:
        target[:] = tracks[k]
        counts[KNOWN], counts[IS_TARGET] = 1, 1
