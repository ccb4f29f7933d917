"""The course of a search for exposure and gain, without a camera: settings out, peaks in."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import dataclass, field
from math import log, sqrt

TARGET = 0.7  # of full scale
# A target that comes nearer by a seventh stays unclipped at the upper end; at the lower one the
# error of a place, which goes with 1 / sqrt(light), is 4 % above that at the middle.
TOLERANCE = 0.05  # of full scale
CLIPPED = 0.99  # of full scale: 8-bit cameras differ in which of the last codes they reach
FASTEST = 8.0  # the most that a faint peak, which is mostly noise, multiplies the exposure by


@dataclass(frozen=True)
class Scale:
    """
    The values that a control may take.

    Parameters
    ----------
    minimum, maximum, step : int
        In units of the control.

    """

    minimum: int
    maximum: int
    step: int = 1

    @property
    def top(self) -> int:
        """Return the index of the greatest value; that of `minimum` is 0."""
        return (self.maximum - self.minimum) // self.step

    def value(self, index: int) -> int:
        """Return the value of an index."""
        return self.minimum + index * self.step

    def index(self, value: float) -> int:
        """Return the index of the greatest value that is not above `value`, within the scale."""
        return min(max(int((value - self.minimum) // self.step), 0), self.top)


@dataclass(frozen=True)
class Outcome:
    """
    What a search came to.

    Parameters
    ----------
    exposure, gain : int or None
        The values to leave the controls at; None if there is no such control.
    peak : float
        The lit peak there, of full scale.
    found : bool
        Whether the peak lies within the tolerance of the target.
    words : str
        The same in a sentence.
    controls : mapping of str to int
        What a search on a camera set, by the control's name: the automatic modes that it
        switched off, exposure and gain.

    """

    exposure: int | None
    gain: int | None
    peak: float
    found: bool
    words: str
    controls: Mapping[str, int] = field(default_factory=dict)


Setting = tuple[int | None, int | None]  # exposure, gain


def search(
    exposure: Scale | None,
    gain: Scale | None,
    start: int = 0,
    target: float = TARGET,
    tolerance: float = TOLERANCE,
) -> Generator[Setting, float, Outcome]:
    """
    Yield settings (exposure, gain); be sent the lit peak that each gives; return the outcome.

    The peak is taken to grow with both, and nothing more: a black level, gain in decibels and
    coarse steps do no harm. Each control is followed by the secant while all that was seen is too
    dark, halved while the peak is clipped, and bracketed from then on.

    Parameters
    ----------
    exposure, gain : Scale or None
        What the controls may be; None if there is none.
    start : int
        Exposure to begin with; gain begins at its minimum.
    target, tolerance : float
        Of full scale. The peak sent is in the same unit, `CLIPPED` and above being clipped.

    """
    at: list[int | None] = [None, gain.minimum if gain else None]
    peak = 0.0
    for place, scale in enumerate((exposure, gain)):
        if scale is None:
            continue
        begin = scale.index(start) if place == 0 else 0
        known = None
        if place == 1 and exposure is not None:
            known = peak  # measured at the least gain already
        seek = _seek(scale, begin, known, place == 0, target, tolerance)
        try:
            at[place] = scale.value(next(seek))
            while True:
                peak = yield at[0], at[1]
                at[place] = scale.value(seek.send(peak))
        except StopIteration as end:
            index, peak = end.value
            at[place] = scale.value(index)
        if peak > target - tolerance:
            break  # as it should be, or too bright, which gain makes no better
    found = abs(peak - target) <= tolerance
    return Outcome(at[0], at[1], peak, found, _words(exposure, gain, at, peak, target, found))


def _words(
    exposure: Scale | None, gain: Scale | None, at: list[int | None], peak: float, target: float,
    found: bool,
) -> str:
    at_peak = f'the lit peak is at {100 * peak:.0f} % of full scale'
    if found:
        return at_peak
    scales = [(scale, value) for scale, value in ((exposure, at[0]), (gain, at[1])) if scale]
    if peak > target and all(value == scale.minimum for scale, value in scales):
        return (f'too bright: {at_peak} with exposure and gain at their least; close the aperture '
                'or put a filter in front of the lens')
    if peak < target and all(value == scale.value(scale.top) for scale, value in scales):
        return (f'too dark: {at_peak} with exposure and gain at their most; open the aperture, '
                'bring more light or allow a longer exposure')
    return f'{at_peak}: the nearest to {100 * target:.0f} % that the steps of the controls allow'


def _seek(
    scale: Scale, index: int, peak: float | None, proportional: bool, target: float,
    tolerance: float,
) -> Generator[int, float, tuple[int, float]]:
    """
    Yield indices; be sent their peaks; return the first index that will do, with its peak.

    Where none does: an end of the scale, or of two neighbours the one that is too dark, for the
    gain to add the rest; of the gain, the nearer.
    """
    dark: list[tuple[int, float]] = []  # too dark, too bright: (index, peak), the latest last
    bright: list[tuple[int, float]] = []
    while True:
        if peak is None:
            peak = yield index
        if abs(peak - target) <= tolerance:
            return index, peak
        (dark if peak < target else bright).append((index, peak))
        if index == (scale.top if peak < target else 0):
            return index, peak
        if not bright:
            index = _brighter(scale, dark, proportional, target)
        elif not dark:
            index //= 2
        elif bright[-1][0] - dark[-1][0] > 1:
            index = _between(dark, bright, proportional, target)
        elif proportional:
            return dark[-1]
        else:
            return min(dark[-1], bright[-1], key=lambda seen: abs(seen[1] - target))
        peak = None


def _brighter(
    scale: Scale, dark: list[tuple[int, float]], proportional: bool, target: float,
) -> int:
    """Return a greater index where all that was seen is too dark."""
    index, peak = dark[-1]
    if not proportional:
        return (index + scale.top + 1) // 2
    value = scale.value(index)
    most = max(FASTEST * value, float(scale.value(index + 1)))
    wanted = value * target / peak if peak > 0.0 else most
    if len(dark) > 1:  # the slope leaves the black level out, which the proportion cannot
        rise = peak - dark[-2][1]
        run = value - scale.value(dark[-2][0])
        wanted = value + (target - peak) * run / rise if rise > 0.0 else most
    return max(index + 1, scale.index(min(wanted, most)))


def _between(
    dark: list[tuple[int, float]], bright: list[tuple[int, float]], proportional: bool,
    target: float,
) -> int:
    """Return an index between the nearest that is too dark and the nearest that is too bright."""
    (low, low_peak), (high, high_peak) = dark[-1], bright[-1]
    # Light comes in proportion to the exposure and, mostly, to the exponential of the gain.
    if (high_peak >= CLIPPED or low_peak <= 0.0 or (len(dark) + len(bright)) % 2):
        # Every second time, so that an uneven response cannot make it creep.
        middle = sqrt((low + 1) * (high + 1)) - 1 if proportional else (low + high) / 2
    elif proportional:
        middle = low + (high - low) * (target - low_peak) / (high_peak - low_peak)
    else:
        middle = low + (high - low) * log(target / low_peak) / log(high_peak / low_peak)
    return min(max(round(middle), low + 1), high - 1)
