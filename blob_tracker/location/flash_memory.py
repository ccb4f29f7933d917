"""What the last flashes of a light tell of the next: motion, kind, lean and flicker."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import replace
import math

from blob_tracker.kernel import Array, exact_kernel
from blob_tracker.location.estimates import Beside
from blob_tracker.location.hypotheses import History, Motion, SWITCHED
from blob_tracker.location.suspicion import HEAD, LEANING
from blob_tracker.types import Location, Window
import numpy as np
from numpy.typing import NDArray

STEADIEST = 0.15  # px: the light's motion is not known better than that
ACCELERATING = 1.5  # of the last change of its displacement, that the next may have
LONGEST = 1.6  # of the last interval between two flashes, that the next may take
REMEMBERED = 32  # flashes, of which is told whether the light is the same in all
FEWEST = 8  # of them, before it can be
FEWEST_FLICKERING = 4  # of them, before it is told whether it is as bright in each
UNLIKE = 0.06  # of the light's mean, by which it differs from flash to flash where it flickers
SIGMAS = 5.0  # of what noise makes of that
SUMMED = 64  # flashes, over which a light's lopsidedness is summed
# A chi-square of two degrees of freedom that noise exceeds once in 1e4: of a light's lopsidedness,
# summed over these flashes
LOPSIDED_FLASHES = 18.4
IMAGE_AXES = np.eye(2)
STANDING = 0.0, 0.0  # in place of the unit vector of a light's way
LOPSIDED, TRAILING, LIGHTS = range(3)  # whose flashes are counted
SAME_SHIFT = 0.5  # of a shift, by which another one may be off and be the same
LEAST_EXCESS = -20.0  # sum that chance makes of equal lights once in 3e3: its sigma is 5.7
DRAWN = 8  # flashes with cut rows, over which it is told how far that draws the light
MOST_DRAWN = 0.75  # of the way from flash to flash, that a streak may be long
ALONG = 0.9  # cosine of the angle between a streak and the path
UNSURE_LAG = 0.15  # of a streak's lag: its path between two flashes is no circle
LEAST_WAY_PX = 1.0  # px from flash to flash, beyond which it is known where the light goes


def _is_near(shift: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    """Tell whether two shifts are one, either way round."""
    apart = min(np.hypot(*(shift - other)), np.hypot(*(shift + other)))
    return bool(apart < SAME_SHIFT * np.hypot(*other))


class FlashMemory:
    """
    The last flashes of one light.

    Attributes
    ----------
    doubt : (2, 2) array or None
        Covariance that the last flash has beside its fit's as the light is lopsided, window px^2;
        None if it is even, as far as anybody can tell.

    """

    def __init__(self) -> None:
        self.doubt: NDArray[np.float64] | None = None
        # In Python's own numbers: arrays of three cost more time.
        self._places: deque[tuple[int, float, float]] = deque(maxlen=3)
        self._evidence: deque[Mapping[str, float]] = deque(maxlen=REMEMBERED)
        self._beside: Beside | None = None  # in sensor px
        self._drawn: deque[float] = deque(maxlen=DRAWN)  # sensor px, of cut rows
        # Rings: of the light, of how it differs from the flash before, and of its noise over it;
        # of the scores of its lopsidedness and their variances' inverse, along x and y, and along
        # its way and across it. Then the sums of these, and how many flashes there were of each.
        self._light = np.zeros((3, REMEMBERED))
        self._scores = np.zeros((2, SUMMED, 4))
        self._sums = np.zeros((2, 4))
        self._counts = np.zeros(3, dtype=np.int64)
        self._is_uneven = False  # whether the last flashes may differ by more than `UNLIKE`

    def add(
        self, location: Location, evidence: Mapping[str, float], *,
        lopsided: Sequence[float] = (), alike: bool = True, beside: Beside | None = None,
        drawn: float = 0.0,
    ) -> None:
        """
        Take the next flash: where and how bright it was, and which models spoke for it.

        How `lopsided` it was is told by two scores and their variances' inverse. How bright it was
        counts where it was seen as in the other flashes (`alike`). The shift to a light `beside`
        it is in px of the sensor, and so is how far its cut rows have `drawn` it.
        """
        if drawn:
            self._drawn.append(drawn * drawn)
        if beside is not None:
            self._remember(beside)
        score_x, score_y, x, y = lopsided or (0.0, 0.0, 0.0, 0.0)
        along, across = (self._way(location) if lopsided else None) or STANDING
        # The flanks of a clipped light do not tell how bright it is.
        even, self._is_uneven = remember_flash(
            self._light, self._scores, self._sums, self._counts, bool(lopsided),
            (score_x, score_y, x, y), (along, across), alike and not location.saturated,
            (location.amplitude, location.sigma, location.snr),
        )
        self._places.append((location.stamp_ns, location.x, location.y))
        self._evidence.append(evidence)
        self.doubt = None if even else self._leaning(along, across)

    def history(self, window: Window) -> History:
        """Return what the last flashes say of the next one."""
        evidence = self._told
        beside = self._beside
        if beside is not None:
            beside = replace(beside, shift=beside.shift / window.binning)
        return History(self._motion(window), self._even, evidence, beside, self._last(window))

    def _last(self, window: Window) -> NDArray[np.float64] | None:
        """Return where the light was in the last flash, window px; None if one may be missing."""
        if len(self._places) < 2:
            return None
        (before, *_), (last, x, y) = list(self._places)[-2:]
        if not 0 < window.stamp_ns - last <= LONGEST * (last - before):
            return None
        return np.array(window.to_window(x, y))

    @property
    def drawn(self) -> float:
        """Return the square of how far cut rows may draw the light unseen, sensor px^2; or 0."""
        if not self._drawn:
            return 0.0
        if not History(evidence=self._told).is_certain(SWITCHED):
            return 0.0
        return max(self._drawn)

    @property
    def _told(self) -> list[Mapping[str, float]]:
        """Return what the models had to say in the flashes in which any of them was heard."""
        return [each for each in self._evidence if each] if any(self._evidence) else []

    def _remember(self, beside: Beside) -> None:
        """Add the light beside the target, of whichever of the two that was taken for it."""
        known = self._beside
        if known is None or not _is_near(beside.shift, known.shift):
            self._beside = beside
            return
        shift = beside.shift
        excess = (1.0 - 1.0 / SUMMED) * known.excess
        if shift @ known.shift < 0.0:
            excess, shift = excess - beside.excess, -shift
        else:
            excess += beside.excess
        # Of two equal ones the first stays the target.
        wrong = excess < LEAST_EXCESS
        self._beside = Beside(-shift, -excess) if wrong else Beside(shift, excess)

    @property
    def _even(self) -> bool:
        """Whether enough flashes are remembered, and lean to no side in their sum."""
        return self._counts.item(LOPSIDED) >= FEWEST and max(
            chi_square(each) for each in self._sums
        ) < LEANING

    def _motion(self, window: Window) -> Motion | None:
        """Return how the light should have moved since its last flash; None if unknown."""
        if len(self._places) < 3:
            return None
        (t0, x0, y0), (t1, x1, y1), (t2, x2, y2) = self._places
        first, second, last = t1 - t0, t2 - t1, window.stamp_ns - t2
        least = min(first, second, last)
        if least <= 0 or max(first, second, last) > LONGEST * least:
            return None
        across, down = window.binning
        flash_x, flash_y = (x2 - x1) * last / second, (y2 - y1) * last / second
        changed = math.hypot(
            (flash_x - (x1 - x0) * last / first) / across,
            (flash_y - (y1 - y0) * last / first) / down,
        )
        return Motion(
            np.array([flash_x / across, flash_y / down]),
            max(STEADIEST, ACCELERATING * changed),
            np.array([
                (x2 - window.x0 + flash_x + 0.5) / across - 0.5,
                (y2 - window.y0 + flash_y + 0.5) / down - 0.5,
            ]),
        )

    def lag(
        self, location: Location, way: NDArray[np.float64]
    ) -> tuple[tuple[float, float], NDArray[np.float64]] | None:
        """
        Return how far a streak's light lies off its path's middle, and the covariance of that.

        On a path with the acceleration a the mean of an exposure E is off the middle by
        a E^2 / 24. The last flashes, T apart, tell a T^2 and the speed, and the streak's length
        E / T over that. From flash to flash the acceleration turns as the way does.

        Parameters
        ----------
        location : Location
            Of the streak's light.
        way : (2,) array
            From one end of the streak to the other, sensor px. If it does not lie along the path,
            or is too long for it, the light does not go there evenly, and there is None.

        """
        if len(self._places) < 3:
            return None
        times = [each[0] for each in self._places] + [location.stamp_ns]
        steps = [after - before for before, after in zip(times, times[1:])]
        if min(steps) <= 0 or max(steps) > LONGEST * min(steps):
            return None
        places = [complex(x, y) for _, x, y in self._places] + [complex(location.x, location.y)]
        before, last, now = (
            (there - here) * steps[-1] / step
            for here, there, step in zip(places, places[1:], steps)
        )
        if min(abs(before), abs(last), abs(now)) < LEAST_WAY_PX:
            return None
        turned = now / last * abs(last / now)
        bend, bend_before = (now - last) * turned, (last - before) * turned**2
        # Of the flash's displacement, which has half of its turn still before it.
        drawn = complex(*way.tolist()) / (now * turned**0.5)
        if abs(drawn) > MOST_DRAWN or abs(drawn.real) < ALONG * abs(drawn):
            return None
        part = abs(drawn) ** 2 / 24.0
        lag, unlike = part * bend, part * (bend - bend_before)
        lags, unlikes = np.array([[lag.real, lag.imag], [unlike.real, unlike.imag]])
        return (lag.real, lag.imag), (
            UNSURE_LAG**2 * np.outer(lags, lags) + np.outer(unlikes, unlikes)
        )

    def _leaning(self, along: float, across: float) -> NDArray[np.float64]:
        """
        Return the covariance that a lopsided light has beside its fit's, window px^2.

        Coma and a lamp beside the light stay where they are in the picture; the tail of a shutter
        that leaks, or of a light that fades, turns with the light's way, whose unit vector is
        given.
        """
        (score_x, score_y, x, y), axes = self._sums[0].tolist(), IMAGE_AXES
        leaning = chi_square(self._sums[0])
        if (along, across) != STANDING and chi_square(self._sums[1]) > leaning:
            (score_x, score_y, x, y), leaning = self._sums[1].tolist(), chi_square(self._sums[1])
            axes = np.array([[along, across], [across, -along]])
        head = HEAD * np.array([score_x / x, score_y / y]) @ axes
        return (1.0 - 2.0 / leaning) * np.outer(head, head)

    def _way(self, location: Location) -> tuple[float, float] | None:
        """Return the unit vector of where the light goes in this flash; None if it stands."""
        if len(self._places) < 2:
            return None
        (t0, x0, y0), (t1, x1, y1) = self._places[-2], self._places[-1]
        t2, x2, y2 = location.stamp_ns, location.x, location.y
        if not 0 < t2 - t1 <= LONGEST * (t1 - t0) or t1 - t0 > LONGEST * (t2 - t1):
            return None
        # Of the parabola through the three.
        before = 0.5 * (t2 - t1) / (t1 - t0)
        u = 1.5 * (x2 - x1) - before * (x1 - x0)
        v = 1.5 * (y2 - y1) - before * (y1 - y0)
        speed = math.hypot(u, v)
        return (u / speed, v / speed) if speed > LEAST_WAY_PX else None

    @property
    def flicker(self) -> float:
        """How much the light differs from flash to flash over its mean; 0 if noise may do so."""
        if not self._is_uneven:
            return 0.0  # most often
        lights = self._counts.item(LIGHTS)
        count = min(lights, REMEMBERED)
        last = np.arange(lights - count, lights) % REMEMBERED
        light, unlike, noise = self._light[:, last].tolist()
        # Of the differences: a light that comes nearer does not flicker.
        # Three quarters of them: bands leave some flashes alike, and something may pass once.
        unlike = sorted(unlike[1:])[3 * (count - 1) // 4] * count / sum(light)
        if unlike <= UNLIKE:
            return 0.0
        return unlike if unlike > SIGMAS * sorted(noise)[count // 2] else 0.0


@exact_kernel
def remember_flash(
    light: Array, scores: Array, sums: Array, counts: NDArray[np.int64], looked: bool,
    lopsided: tuple[float, float, float, float], way: tuple[float, float], alike: bool,
    pulse: tuple[float, float, float],
) -> tuple[bool, bool]:
    """
    Take the next flash of a light.

    Parameters
    ----------
    light : (3, 32) array
        Ring of amplitude times sigma^2, of how far that is off the one before, and of the noise
        over it.
    scores : (2, 64, 4) array
        Rings of its lopsidedness along x and y, and along its way and across it.
    sums : (2, 4) array
        Of these.
    counts : (3,) array
        Flashes that there were in either ring of scores, and in that of the light.
    looked : bool
        Whether anybody looked for its lopsidedness.
    lopsided : (float, float, float, float)
        Its scores along x and y, and their variances' inverse.
    way : (float, float)
        Unit vector of where it goes; (0, 0) if it stands.
    alike : bool
        Whether it was seen as in the other flashes.
    pulse : (float, float, float)
        Its amplitude, DN, its sigma, px, and its SNR.

    Returns
    -------
    bool, bool
        Whether it is even, as far as anybody can tell, and whether some of the last flashes may
        differ by more than `UNLIKE`.

    """
    even = True
    if looked:
        score_x, score_y, x, y = lopsided
        along, across = way
        _add_score(scores[0], sums[0], counts, LOPSIDED, (score_x, score_y, x, y))
        leaning = chi_square(sums[0])
        if along != 0.0 or across != 0.0:
            _add_score(scores[1], sums[1], counts, TRAILING, (
                along * score_x + across * score_y, across * score_x - along * score_y,
                along * along * x + across * across * y, across * across * x + along * along * y,
            ))
            leaning = max(leaning, chi_square(sums[1]))
        even = leaning < LOPSIDED_FLASHES
    if alike:
        amplitude, sigma, snr = pulse
        now, last = counts[LIGHTS] % REMEMBERED, (counts[LIGHTS] - 1) % REMEMBERED
        light[0, now] = amplitude * (sigma * sigma)
        light[1, now] = abs(light[0, now] - light[0, last])
        light[2, now] = 1.0 / (snr * max(sigma, 0.5))
        counts[LIGHTS] += 1
    count = min(counts[LIGHTS], REMEMBERED)
    if count < FEWEST_FLICKERING:
        return even, False
    total, farthest = 0.0, 0.0
    for k in range(counts[LIGHTS] - count, counts[LIGHTS]):
        total += light[0, k % REMEMBERED]
        if k > counts[LIGHTS] - count:  # of the first, the one before it is forgotten
            farthest = max(farthest, light[1, k % REMEMBERED])
    return even, farthest * count / total > UNLIKE


@exact_kernel
def _add_score(
    ring: Array, sums: Array, counts: NDArray[np.int64], which: int,
    score: tuple[float, float, float, float],
) -> None:
    """Take the lopsidedness of the next flash, and forget that of the one `SUMMED` before it."""
    place = counts[which] % SUMMED
    for k in range(4):
        change = score[k]
        if counts[which] >= SUMMED:
            change -= ring[place, k]
        ring[place, k] = score[k]
        sums[k] += change
    counts[which] += 1


@exact_kernel
def chi_square(sums: Array) -> float:
    """Return that of two degrees of freedom of a light; 0 where nothing is known yet."""
    if not (sums[2] > 0.0 and sums[3] > 0.0):
        return 0.0
    return float(sums[0] * sums[0] / sums[2] + sums[1] * sums[1] / sums[3])


def compile_memory() -> None:
    """Compile what remembers flashes, or load it."""
    memory = FlashMemory()
    memory.add(
        Location(0.0, 0.0, IMAGE_AXES, 1.0, 0.0, 1.0, 1.0, 1.0, 0), {}, lopsided=(0.0,) * 4)
    chi_square(np.zeros(4))
