"""Lights that blink a sequence of bits each, told apart by their codes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from blob_tracker.segmentation.box import Box, box_about, whole
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.history import FrameError, FrameHistory
from blob_tracker.types import Frame, Pixels
import numpy as np
from numpy.typing import NDArray

GATE_PX = 6  # px that a light may move between two of its rises, and the reach of its place
LEAST_SWING_SIGMA = 6.0  # standard deviations that a light which still blinks goes up and down by
# Frames of a code: half a minute at 60 Hz; every phase of it is compared
LONGEST_CODE_FRAMES = 2048
MOST_LIGHTS = 16  # of one frame: what has more rises than that is no scene of lights


@dataclass
class _Spot:
    """A place where light rose, and how bright it was in each of the last frames."""

    column: int
    row: int
    levels: list[float] = field(default_factory=list)


class Coded:
    """
    Follow every place where light rises, and read its bits.

    A light repeats its code for ever, one bit for every `frames_per_bit` frames, from any phase.
    The brightness of its place over one length of the code, parted half-way between its extremes,
    is compared with every code in every phase. The light is named where one code differs from it
    by no more than `bit_errors` bits, and is given out in each frame in which it rose.

    Parameters
    ----------
    max_pair_interval : float
        Greatest time from one frame to the next, s; a longer gap forgets all lights.
    codes : mapping of str to str
        Bits of each light by its name: '1101000'. All of one length.
    frames_per_bit : int
        Frames in which a bit is held.
    bit_errors : int
        Bits of a code that may be wrong.

    Raises
    ------
    ValueError
        Where a code is not one, or two of them are too alike to be told apart.

    """

    surveys = False
    warning = ''

    def __init__(
        self,
        *,
        codes: Mapping[str, str],
        max_pair_interval: float = 0.1,
        frames_per_bit: int = 1,
        bit_errors: int = 0,
    ) -> None:
        check_codes(codes, bit_errors)
        length = frames_per_bit * max(len(bits) for bits in codes.values())
        if length > LONGEST_CODE_FRAMES:
            raise ValueError(
                f'a code of {length} frames is too long to be read; it must have at most '
                f'{LONGEST_CODE_FRAMES}, frames_per_bit included'
            )
        self.reason = 'no frame yet'
        self._tolerance = bit_errors * frames_per_bit
        self._phases = {name: _phases(bits, frames_per_bit) for name, bits in codes.items()}
        self._length = next(iter(self._phases.values())).shape[1]
        self._history = FrameHistory(2, max_pair_interval)
        self._spots: list[_Spot] = []

    @property
    def locked(self) -> bool:
        """Whether any light has shown its code."""
        return any(self._name(each.levels) for each in self._spots)

    def contrast(self, frame: Frame, expected: Expectation | None = None) -> Contrast | None:
        """
        Return the next frame and the one before it.

        Raises
        ------
        FrameError
            Where the frame cannot follow the one before it.

        """
        try:
            interval = self._history.push(frame)
        except FrameError:
            if len(self._history.frames) == 1:
                self._spots.clear()
            raise
        if interval is None or len(self._history.frames) < 2:
            self._spots.clear()
            self.reason = 'waiting for a second frame'
            return None
        self.reason = ''
        before, after = self._history.frames
        unlit, lit = before.image, after.image
        for spot in self._spots:
            spot.levels.append(_level(lit, spot))
            del spot.levels[:-self._length]
        return Contrast(
            lit, unlit, frame.saturation, frame, (after.samples,), (before.samples,),
            duration=self._length * interval,
        )

    def skip(self, frame: Frame) -> None:
        """Do nothing: it is as if the frame had not come."""

    def region(self, contrast: Contrast) -> Box:
        """Return the whole frame: the lights may be anywhere in it."""
        return whole(contrast.shape)

    def widened(self, contrast: Contrast, candidates: Sequence[Candidate]) -> None:
        """Return None: the whole frame is searched in any case."""

    def survey(self, contrast: Contrast, candidates: Sequence[Candidate]) -> None:
        """Do nothing: `choose` had the whole frame."""

    def choose(
        self, contrast: Contrast, candidates: Sequence[Candidate]
    ) -> list[tuple[str, Candidate]]:
        """Return the known lights that lit up, each by its name."""
        allowed = [each for each in candidates if not each.rejected]
        found: dict[str, Candidate] = {}
        for candidate in allowed[:MOST_LIGHTS]:
            spot = self._spot_at(*candidate.peak, contrast.lit, contrast.unlit)
            name = self._name(spot.levels)
            # The codes are unlike, but a reflection blinks as its light does.
            if name and (name not in found or candidate.snr > found[name].snr):
                found[name] = candidate
        noise = max((each.noise for each in candidates), default=contrast.floor)
        self._spots = [each for each in self._spots if self._lives(each, noise)]
        if not found and self._spots:
            self.reason = f'{len(self._spots)} places blink; no code of a light has begun in them'
        return list(found.items())

    def _spot_at(self, column: int, row: int, image: Pixels, unlit: Pixels) -> _Spot:
        """Return the spot that rose here, moved to the rise; a new one where there is none."""
        for spot in self._spots:
            if max(abs(spot.column - column), abs(spot.row - row)) <= GATE_PX:
                spot.column, spot.row = column, row
                return spot
        spot = _Spot(column, row)
        spot.levels = [_level(unlit, spot), _level(image, spot)]
        self._spots.append(spot)
        return spot

    def _lives(self, spot: _Spot, noise: float) -> bool:
        """Tell whether a spot still blinks: it has not been of one level for a whole code."""
        swing = max(spot.levels) - min(spot.levels)
        return len(spot.levels) < self._length or swing >= LEAST_SWING_SIGMA * noise

    def _name(self, levels: Sequence[float]) -> str:
        """Return the name of the light with these levels; empty where it is none or unsure."""
        if len(levels) < self._length:
            return ''
        bits = np.asarray(levels) > 0.5 * (max(levels) + min(levels))
        for name, phases in self._phases.items():
            if int((phases != bits).sum(axis=1).min()) <= self._tolerance:
                return name
        return ''


def check_codes(codes: Mapping[str, str], bit_errors: int) -> None:
    """
    Raise ValueError where the codes cannot be told apart with so many wrong bits.

    Any two, in any phase, must differ by more than twice `bit_errors`: a sequence is then never
    within `bit_errors` of both.
    """
    if not codes:
        raise ValueError("there is no code; write them as 'port:1101000,starboard:1110100'")
    for name, bits in codes.items():
        if not (name.isidentifier() and name.isascii()):
            raise ValueError(f"a light is called '{name}'; it must be a word fit for a topic")
        if set(bits) != {'0', '1'}:
            raise ValueError(f"the code of '{name}' is '{bits}'; it must have zeros and ones")
    if len({len(bits) for bits in codes.values()}) > 1:
        raise ValueError('the codes differ in length; all must have the same')
    names = list(codes)
    for index, first in enumerate(names):
        for second in names[index + 1:]:
            bits = _phases(codes[first], 1)[0]
            least = int((_phases(codes[second], 1) != bits).sum(axis=1).min())
            if least <= 2 * bit_errors:
                raise ValueError(
                    f"the codes of '{first}' and '{second}' differ by {least} bits in some phase; "
                    f'with {bit_errors} wrong bits tolerated it must be {2 * bit_errors + 1}'
                )


def _phases(bits: str, frames_per_bit: int) -> NDArray[np.bool_]:
    """Return (n, n) bits of a code, one row for each frame at which it may begin."""
    frames = np.repeat([bit == '1' for bit in bits], frames_per_bit)
    return np.stack([np.roll(frames, shift) for shift in range(frames.size)])


def _level(image: Pixels, spot: _Spot) -> float:
    """Return the brightest pixel about a spot, DN."""
    about: Box = box_about(spot.column, spot.row, GATE_PX, GATE_PX, image.shape)
    return float(image[about.slices].max())
