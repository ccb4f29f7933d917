"""What is a light in step, and what are glints that fell in line by chance: a likelihood ratio."""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel
import numpy as np

# Columns of a track: place and speed (px, px a flash), their variances along either axis,
# logarithm of the brightness, log-likelihood ratios over chance and over something that flickers
# at one place, frame of the last flash and which light of that frame it was, flashes, kind of
# motion, what the last flash added to the first ratio, and which light of which frame it began
# with.
(
    X, Y, VX, VY, VAR_X, COV_XV, VAR_V, BRIGHTNESS, SCORE, STEADY, FRAME, LIGHT, FLASHES, KIND,
    GAIN, FAMILY,
) = range(16)
FIELDS = 16
# Columns of a light: place, px; variance of the place along an axis, px^2; logarithm of the
# brightness; logarithm of how many glints are like it, 1/px^2 and e-fold; 0 where it is rejected.
LIGHT_X, LIGHT_Y, LIGHT_VARIANCE, LIGHT_BRIGHTNESS, LIGHT_CHANCE, LIGHT_ALLOWED = range(6)
# Kinds of motion, each as likely: px that a place trembles by, and px a flash that the speed
# changes by from one flash to the next: at rest or even, in a hand or rocking, turning.
KINDS = np.array([[0.15, 0.05], [0.6, 0.4], [0.5, 4.0]])
SLOW_PX = 2.0  # px a flash: half of the targets are so slow, the others anything up to the gate
SEEN = 0.9  # of the flashes are seen: glints cover some
# Of the brightness, e-folds: of most flashes, and of one in five (by distance and direction)
LIKE, UNLIKE, UNLIKE_PART = 0.15, 0.6, 0.2
OFTEN = 0.5  # of the frames in which a thing lights up that flickers at one place: the worst
GATE2 = 16.0  # squared distance, in variances: one of a target's flashes in 3000 is farther
LAST_FRAMES = 8  # frames without a flash after which a track ends
FAINTEST = -6.0  # log-likelihood ratio: below it chance alone is far likelier
FAMILIES = 1e5  # more than lights are looked at in four frames
RIVALS = 2  # tracks of each kind that a light may continue: its own, and what crosses it


@kernel
def advance(
    tracks: Array, earlier: Array, lights: Array, frame: float, gate_px: float
) -> Array:
    """
    Carry the tracks on to the next frame.

    Each track is a target's as against chance, and has the logarithm of the likelihood ratio

        ln L <- ln L + ln[p_D N(d; S) g(b) / c(x, b)]      of a light that continues it,
        ln L <- ln L + ln(1 - p_D)                         where it is missed,

    with the innovation d and its variance S of a Kalman filter at an even speed, the likeness g of
    the brightness and the density c of glints (Sittler, IEEE Trans. Mil. Electron. 8 (1964);
    Reid, IEEE Trans. Autom. Control 24 (1979)). Over glints that are independent from frame to
    frame the mean of L, summed over all that may continue a track, stays 1: so chance alone takes
    any that began above a bound with the probability 1 / bound at most (Ville, 1939; Wald, 1945).
    A second ratio is that over a thing that flickers at one place in half of the frames, whatever
    the phase: a light right there in the frame between two flashes speaks for that.

    Parameters
    ----------
    tracks : (n, 16) array
        Columns as above.
    earlier : (k, 7) array
        Lights of earlier frames, and their frame in the last column.
    lights : (m, 6) array
        Those of this one; the rejected ones only speak against what is out of step.
    frame : float
        Its number, counted by the stamps.
    gate_px : float
        Greatest way from one flash to the next, px.

    Returns
    -------
    (n, 16) array
        The tracks.

    """
    slots = RIVALS * KINDS.shape[0]
    born = np.empty((slots * lights.shape[0], FIELDS))
    born[:, SCORE] = -np.inf
    out = np.empty((tracks.shape[0] + born.shape[0], FIELDS))
    count = 0
    row = np.empty(FIELDS)
    for n in range(tracks.shape[0]):
        track = tracks[n]
        passed = frame - track[FRAME]
        if passed > LAST_FRAMES:
            continue
        shake, turn = KINDS[int(track[KIND])]
        flashes = 0.5 * passed
        x, y = track[X] + flashes * track[VX], track[Y] + flashes * track[VY]
        change = (turn * flashes) ** 2
        xx = track[VAR_X] + flashes * (2.0 * track[COV_XV] + flashes * track[VAR_V])
        xx += 0.25 * change * flashes * flashes
        xv = track[COV_XV] + flashes * track[VAR_V] + 0.5 * change * flashes
        vv = track[VAR_V] + change
        due = int(passed) % 2 == 0
        worst, reach = 0.0, 4.0 * np.sqrt(xx + shake * shake + 1.0)
        for i in range(lights.shape[0]):
            light = lights[i]
            dx, dy = light[LIGHT_X] - x, light[LIGHT_Y] - y
            if abs(dx) > reach or abs(dy) > reach:
                continue
            spread = xx + shake * shake + light[LIGHT_VARIANCE]
            away = (dx * dx + dy * dy) / spread
            if away > GATE2:
                continue
            like = _likeness(light[LIGHT_BRIGHTNESS] - track[BRIGHTNESS])
            gain = np.log(like / (2.0 * np.pi * spread)) - 0.5 * away - light[LIGHT_CHANCE]
            if not due:
                worst = min(worst, -np.log1p(OFTEN * np.exp(min(gain, 50.0))))
            elif light[LIGHT_ALLOWED] > 0.0:
                row[:] = track
                gain_x, gain_v = xx / spread, xv / spread
                row[X], row[Y] = x + gain_x * dx, y + gain_x * dy
                row[VX], row[VY] = track[VX] + gain_v * dx, track[VY] + gain_v * dy
                row[VAR_X], row[COV_XV] = xx * (1.0 - gain_x), xv * (1.0 - gain_x)
                row[VAR_V] = vv - gain_v * xv
                row[FLASHES] += 1.0
                row[BRIGHTNESS] += (light[LIGHT_BRIGHTNESS] - track[BRIGHTNESS]) / min(
                    row[FLASHES], LAST_FRAMES
                )
                row[GAIN] = np.log(SEEN) + gain
                row[SCORE] += row[GAIN]
                row[STEADY] += np.log(SEEN / OFTEN)
                row[FRAME], row[LIGHT] = frame, i
                _offer(born, row, slots * i)
        out[count] = track
        if due:
            out[count, SCORE] += np.log(1.0 - SEEN)
            out[count, STEADY] += np.log((1.0 - SEEN) / (1.0 - OFTEN))
        elif worst < 0.0:
            out[count, STEADY] += worst
        else:
            out[count, STEADY] -= np.log(1.0 - OFTEN)
        if out[count, SCORE] > FAINTEST:
            count += 1
    for n in range(earlier.shape[0]):
        passed = frame - earlier[n, 6]
        if int(passed) % 2 == 0 and passed <= 4:
            row[FAMILY] = n + FAMILIES * earlier[n, 6]
            _begin(row, earlier[n], lights, frame, passed, gate_px, born, slots)
    for n in range(born.shape[0]):
        if born[n, SCORE] > FAINTEST:
            out[count] = born[n]
            count += 1
    return out[:count].copy()


@kernel
def _begin(
    row: Array, first: Array, lights: Array, frame: float, passed: float, gate_px: float,
    born: Array, slots: int,
) -> None:
    """Begin tracks of two flashes, one of each kind, from a light of an earlier frame."""
    flashes = 0.5 * passed
    farthest = gate_px * flashes
    for i in range(lights.shape[0]):
        light = lights[i]
        dx, dy = light[LIGHT_X] - first[LIGHT_X], light[LIGHT_Y] - first[LIGHT_Y]
        away = dx * dx + dy * dy
        if light[LIGHT_ALLOWED] == 0.0 or away > farthest * farthest:
            continue
        slow = (SLOW_PX * flashes) ** 2
        near = 0.5 * np.exp(-0.5 * away / slow) / (2.0 * np.pi * slow)
        near += 0.5 / (np.pi * farthest * farthest)
        like = _likeness(light[LIGHT_BRIGHTNESS] - first[LIGHT_BRIGHTNESS])
        row[SCORE] = np.log(SEEN * like * near / KINDS.shape[0]) - light[LIGHT_CHANCE]
        row[SCORE] += (flashes - 1.0) * np.log(1.0 - SEEN)
        if row[SCORE] <= FAINTEST:
            continue
        row[GAIN] = row[SCORE]
        row[STEADY] = 2.0 * np.log(SEEN / OFTEN) - np.log(1.0 - OFTEN)
        row[X], row[Y] = light[LIGHT_X], light[LIGHT_Y]
        row[VX], row[VY] = dx / flashes, dy / flashes
        row[BRIGHTNESS] = 0.5 * (light[LIGHT_BRIGHTNESS] + first[LIGHT_BRIGHTNESS])
        row[FRAME], row[LIGHT], row[FLASHES] = frame, i, 2.0
        for kind in range(KINDS.shape[0]):
            shake, turn = KINDS[kind]
            variance = shake * shake + light[LIGHT_VARIANCE]
            before = shake * shake + first[LIGHT_VARIANCE]
            row[VAR_X], row[COV_XV] = variance, variance / flashes
            row[VAR_V] = (variance + before) / (flashes * flashes) + turn * turn
            row[KIND] = kind
            _offer(born, row, slots * i)


@kernel
def _offer(born: Array, row: Array, first: int) -> None:
    """Keep a track among the best ones of its kind that end in one light."""
    start = first + RIVALS * int(row[KIND])
    for k in range(start, start + RIVALS):
        if row[SCORE] > born[k, SCORE]:
            for later in range(start + RIVALS - 1, k, -1):
                born[later] = born[later - 1]
            born[k] = row
            return


@kernel
def _likeness(ratio: float) -> float:
    """Return the density of a change of brightness, 1 / e-fold."""
    often = (1.0 - UNLIKE_PART) / LIKE * np.exp(-0.5 * (ratio / LIKE) ** 2)
    seldom = UNLIKE_PART / UNLIKE * np.exp(-0.5 * (ratio / UNLIKE) ** 2)
    return float((often + seldom) / np.sqrt(2.0 * np.pi))
