"""How lights blink, and what an exposure sees of it in each phase."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import NamedTuple

from blob_tracker.kernel import Array
import numpy as np
from numpy.typing import NDArray

CELLS_A_FRAME = 16  # phase cells in a frame interval: a step of 1/16 of it is 1 ms at 60 Hz
SUB_CELLS = 2  # looks within a cell, over which share and time are tabulated
IN_A_LOOK = 8  # phases of which a look is the mean
LEAST_CELLS = 48  # of a period: a wave of few frames is followed as finely as a code
LEAST_STEP = 1e-3  # of the share from look to look: of less the slope is not to be told
LONGEST_BITS = 64  # of a code: the phase is looked for in all of it
MAINS_HZ = (100.0, 120.0)  # of lamps on 50 and 60 Hz
SHARE_LEVELS = 128  # steps of the share, so that a frame needs few exponentials


@dataclass(frozen=True)
class Pattern:
    """
    One light's way to blink.

    Parameters
    ----------
    name : str
        The light.
    period : float
        After which it repeats, s.
    edges : tuple of (float, float)
        Begin and end of each time for which it is on, as parts of the period.
    frames : int
        Frame intervals of a period, of a light in step with the camera: frames are counted then,
        whatever their stamps. 0 of one that runs free.

    Examples
    --------
    A double flash each second:

    >>> pattern = Pattern('mast', period=1.0, edges=((0.0, 0.1), (0.2, 0.3)))
    >>> round(pattern.longest_dark, 2)  # s
    0.7

    """

    name: str
    period: float
    edges: tuple[tuple[float, float], ...]
    frames: int = 0

    @property
    def longest_dark(self) -> float:
        """Return the longest time for which the light is off, s."""
        begins = [begin for begin, _ in self.edges[1:]] + [1.0 + self.edges[0][0]]
        gaps = [begin - end for begin, (_, end) in zip(begins, self.edges)]
        return self.period * max(gaps)


def code(name: str, bits: str, bits_per_second: float, frames_per_bit: int = 0) -> Pattern:
    """
    Return the pattern of a light that sends bits for ever.

    Parameters
    ----------
    name : str
        The light.
    bits : str
        '1' where it is on: '1101000'.
    bits_per_second : float
        By the light's own clock.
    frames_per_bit : int
        Of a light that is in step with the camera; 0 of one that runs free.

    Examples
    --------
    Seven bits at 20 bits/s:

    >>> pattern = code('beacon', '1101000', 20.0)
    >>> pattern.period, len(pattern.edges)  # s, times for which it is on
    (0.35, 2)
    >>> round(pattern.longest_dark, 2)  # s
    0.15

    """
    length = len(bits)
    # A run that goes on past the end of the code is one run: begin at a rise.
    first = (bits[-1] + bits).find('01') if '01' in bits[-1] + bits else 0
    turned = bits[first:] + bits[:first]
    edges: list[tuple[float, float]] = []
    for index, bit in enumerate(turned):
        if bit == '1' and index > 0 and turned[index - 1] == '1':
            edges[-1] = (edges[-1][0], (index + 1) / length)
        elif bit == '1':
            edges.append((index / length, (index + 1) / length))
    return Pattern(
        name, length / bits_per_second, tuple(edges), length * frames_per_bit
    )


def wave(name: str, frequency: float, duty: float) -> Pattern:
    """
    Return the pattern of a light that is on for a part of each period; Hz, 0 to 1.

    Examples
    --------
    A light that is on for a quarter of the time:

    >>> pattern = wave('port', 12.5, 0.25)
    >>> pattern.period, pattern.edges  # s, parts of it
    (0.08, ((0.0, 0.25),))

    """
    return Pattern(name, 1.0 / frequency, ((0.0, duty),))


class Tables(NamedTuple):
    """
    What an exposure sees of each pattern in each phase, in units of the frame interval.

    Parameters
    ----------
    first : (p + 1,) int array
        Index of each pattern's first cell; the last one is the count of cells.
    rate : (p,) array
        Looks by which a pattern goes on in a frame interval.
    level : (SUB_CELLS * cells,) uint8 array
        Share of the exposure for which the light is on, in steps of 1 / SHARE_LEVELS.
    tau : (SUB_CELLS * cells,) array
        Middle of the time for which it is on, from the middle of the exposure.
    share : (SUB_CELLS * cells,) array
        The share itself.
    slope : (SUB_CELLS * cells,) array
        d tau / d share along the phase; 0 where the share does not change.

    """

    first: NDArray[np.int64]
    rate: Array
    level: NDArray[np.uint8]
    tau: Array
    share: Array
    slope: Array


def tables(patterns: Sequence[Pattern], interval: float, exposure: float) -> Tables:
    """
    Tabulate the patterns for a camera.

    With b(t) the light's brightness and E the exposure about the phase phi,

        s = 1/E integral of b,   tau = integral of (t - phi) b / integral of b.

    Parameters
    ----------
    patterns : sequence of Pattern
        The lights.
    interval, exposure : float
        From frame to frame, and of a frame, s.

    """
    first, rates = [0], []
    shares, taus, slopes = [], [], []
    for pattern in patterns:
        frames = pattern.frames or pattern.period / interval
        count = max(math.ceil(CELLS_A_FRAME * frames), LEAST_CELLS)
        share, tau = _means(*look(pattern, count * SUB_CELLS * IN_A_LOOK, exposure))
        first.append(first[-1] + count)
        rates.append(SUB_CELLS * count / frames)
        shares.append(share)
        taus.append(tau / interval)
        slopes.append(_slopes(share, taus[-1]))
    share = np.concatenate(shares)
    return Tables(
        np.array(first), np.array(rates), np.rint(SHARE_LEVELS * share).astype(np.uint8),
        np.concatenate(taus), share, np.concatenate(slopes),
    )


def look(pattern: Pattern, steps: int, exposure: float) -> tuple[Array, Array]:
    """
    Return share and time, s, that an exposure sees of a pattern at so many phases of it.

    The integrals of b and of t b are piecewise polynomials: they are taken from edge to edge, not
    sampled.
    """
    phase = (np.arange(steps) + 0.5) / steps * pattern.period
    total, moment = np.zeros(steps), np.zeros(steps)
    reach = math.ceil(exposure / pattern.period) + 1
    for turn in range(-reach, reach + 1):
        for begin, end in pattern.edges:
            on = np.clip((begin + turn) * pattern.period - phase, -0.5 * exposure, 0.5 * exposure)
            off = np.clip((end + turn) * pattern.period - phase, -0.5 * exposure, 0.5 * exposure)
            total += off - on
            moment += 0.5 * (off**2 - on**2)
    share = np.clip(total / exposure, 0.0, 1.0)
    tau = np.divide(moment, total, out=np.zeros(steps), where=total > 1e-9 * exposure)
    return share, tau


def _means(share: Array, tau: Array) -> tuple[Array, Array]:
    """Return share and time of looks, each the mean over its width, the time where it is lit."""
    share, tau = share.reshape(-1, IN_A_LOOK), tau.reshape(-1, IN_A_LOOK)
    return share.mean(axis=1), tau.sum(axis=1) / np.maximum((share > 0.0).sum(axis=1), 1)


def _slopes(share: Array, tau: Array) -> Array:
    """
    Return d tau / d share at each look, from a neighbour that an edge of the light runs through.

    With one edge in the exposure it is a straight line, from look to look as well as beyond.
    """
    slopes = np.zeros_like(share)
    for side in (1, -1):
        other, there = np.roll(share, side), np.roll(tau, side)
        straight = (share > 0.0) & (share < 1.0) & (other > 0.0) & (other < 1.0)
        straight &= np.abs(other - share) > LEAST_STEP
        slopes[straight] = (there - tau)[straight] / (other - share)[straight]
    return slopes
