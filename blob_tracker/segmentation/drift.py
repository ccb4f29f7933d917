"""Whether a light in step drifts: it goes over from the frames it is on in to the others."""

from __future__ import annotations

from collections import deque
import math

from blob_tracker.kernel import kernel
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray

# The last flashes over which a line is laid: a beat of a second is seen in the first, one of a
# minute in the last.
SPANS = (12, 24, 48, 96, 192)
CHECKED = 6  # flashes from one look at them to the next
LEAST_RISE = 0.08  # of the light, that goes over in a span
LEAST_T = 8.0  # standard deviations of the line's slope
SMOOTHED = 3  # flashes, whose mean is compared with those before
NOISE_MEMORY = 0.1  # of the mean square that a flash renews
# Log-likelihood by which one explanation is beyond the others, and that one place takes at most.
DECIDED, MOST_AGAINST = 12.0, 4.0
LEAST_SIGMA = 5.0  # standard deviations of such a mean, by which it is another one
APERTURE, NEAR, FAR = 3.0, 4.0, 6.0  # sigma: of the light, and of the ring about it


class DriftWatch:
    """
    Compare the light in the lit frames with that in the unlit ones, flash by flash.

    Of a light that runs free near half the frame rate the one falls as the other rises, at an
    even rate. A lamp that it passes is in both, one that is switched on stays, and a light that
    recedes is in the lit frames alone.
    """

    def __init__(self) -> None:
        self._flashes: deque[tuple[float, float, float]] = deque(maxlen=SPANS[-1])
        self._count = 0
        self._means = 0.0, 0.0
        # Of all means: the least and the most.
        self._lit, self._unlit = (math.inf, -math.inf), (math.inf, -math.inf)
        self._square = 0.0  # of the change from flash to flash

    @property
    def share(self) -> float:
        """
        Return the part of the light that has gone over to the unlit frame, as it seems so far.

        It is what is both missing in the one and new in the other, beyond the noise.
        """
        lit, unlit = self._means
        noise = LEAST_SIGMA * math.sqrt(self._square / SMOOTHED)
        over = min(self._lit[1] - lit, unlit - self._unlit[0])
        return over / max(lit + unlit, 1e-9) if over > noise > 0.0 else 0.0

    def add(self, time: float, lit: float, unlit: float) -> float:
        """
        Take a flash; return the part of the light that goes over in a second, 0 where none does.

        Parameters
        ----------
        time : float
            Its stamp, s.
        lit, unlit : float
            Light above its surroundings where it is and where it was a frame before, DN.

        """
        if self._flashes:
            _, before, _ = self._flashes[-1]
            self._square += NOISE_MEMORY * (0.5 * (lit - before) ** 2 - self._square)
        self._flashes.append((time, lit, unlit))
        self._count += 1
        if self._count < SMOOTHED:
            return 0.0
        last = [self._flashes[-k] for k in range(1, SMOOTHED + 1)]
        lit, unlit = (sum(each[k] for each in last) / SMOOTHED for k in (1, 2))
        self._means = lit, unlit
        self._lit = min(self._lit[0], lit), max(self._lit[1], lit)
        self._unlit = min(self._unlit[0], unlit), max(self._unlit[1], unlit)
        changed = min(self._lit[1] - self._lit[0], self._unlit[1] - self._unlit[0])
        if (
            self._count % CHECKED or len(self._flashes) < SPANS[0]
            or changed < 0.5 * LEAST_RISE * (lit + unlit)
        ):
            return 0.0
        table = np.array(self._flashes)
        rates = (_going_over(*table[-span:].T) for span in SPANS if span <= len(table))
        return next((rate for rate in rates if rate), 0.0)


def _going_over(
    times: NDArray[np.float64], lit: NDArray[np.float64], unlit: NDArray[np.float64]
) -> float:
    """Return the part that goes over from the one to the other along a line, 1/s; or 0."""
    whole = float(np.mean(lit + unlit))
    if whole <= 0.0:
        return 0.0
    fall, fall_t = _slope(times, lit)
    rise, rise_t = _slope(times, unlit)
    span = float(times[-1] - times[0])
    if (
        fall * rise >= 0.0
        or min(abs(fall_t), abs(rise_t)) < LEAST_T
        or min(abs(fall), abs(rise)) * span < LEAST_RISE * whole
    ):
        return 0.0
    return 0.5 * (rise - fall) / whole


def _slope(x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[float, float]:
    """Return the slope of a line through points, and it over its standard deviation."""
    away = x - x.mean()
    square = float(away @ away)
    if square == 0.0:
        return 0.0, 0.0
    slope = float(away @ y) / square
    left = y - y.mean() - slope * away
    deviation = math.sqrt(max(float(left @ left), 1e-12) / ((len(x) - 2) * square))
    return slope, slope / deviation


class GhostInstants:
    """
    Tell by where a moving light is in the unlit frame when within the exposure it was seen.

    A light that is partly on in both frames of a pair was on at the end of the one exposure and
    at the start of the other, or the other way round: its two places are farther apart than its
    way from frame to frame, or less far, by its way in half an exposure. One that is never quite
    off is just as far; and where a filter mixes frames the place is that of the last flash.
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Hold nothing against any of them."""
        # Late, early, never off, filtered: half chi-squares.
        self._against = [0.0, 0.0, 0.0, 0.0]

    def add(self, ahead: float, deviation: float, frame: float) -> None:
        """
        Take a place.

        Parameters
        ----------
        ahead : float
            How far the light in the unlit frame is ahead of where it was in the middle of that, in
            ways of half an exposure.
        deviation : float
            Standard deviation of that.
        frame : float
            Way from one frame to the next in the same unit.

        """
        for k, there in enumerate((-1.0, 1.0, 0.0, -frame)):
            # What nothing explains is held against none of them.
            self._against[k] += min(0.5 * ((ahead - there) / deviation) ** 2, MOST_AGAINST)

    @property
    def side(self) -> int:
        """1 of a light that was on at the end of the lit exposure, -1 at its start; else 0."""
        late, early, *others = self._against
        if min(late, early) + DECIDED > min(*others, max(late, early)):
            return 0
        return 1 if late < early else -1


@kernel
def light_at(
    image: Pixels, x: float, y: float, sigma: float
) -> tuple[float, tuple[float, float], int]:
    """
    Return the light within APERTURE sigma of a place above the ring about it.

    In DN px^2, with its centroid, px, and of how many pixels it is the sum.
    """
    height, width = image.shape
    reach = FAR * sigma
    total, across, down, count, level, around = 0.0, 0.0, 0.0, 0, 0.0, 0
    for j in range(max(int(y - reach), 0), min(int(y + reach) + 2, height)):
        for i in range(max(int(x - reach), 0), min(int(x + reach) + 2, width)):
            distance = math.sqrt((i - x) ** 2 + (j - y) ** 2)
            value = float(image[j, i])
            if distance < APERTURE * sigma:
                total += value
                across += value * (i - x)
                down += value * (j - y)
                count += 1
            elif NEAR * sigma < distance < reach:
                level += value
                around += 1
    if count == 0 or around == 0:
        return 0.0, (x, y), 0
    total -= count * level / around
    if total <= 0.0:
        return 0.0, (x, y), count
    return total, (x + across / total, y + down / total), count
