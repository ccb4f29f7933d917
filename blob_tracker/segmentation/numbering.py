"""Which of several lights that look alike is which, from frame to frame."""

from __future__ import annotations

from collections.abc import Sequence
import math

from blob_tracker.flash_text import numbered_lights
from blob_tracker.segmentation.candidate import Candidate


class Numbering:
    """
    Give lights that look alike numbers, and keep them by where the lights are.

    Each goes on with the nearest that was seen before, the nearest pairs first; what is new has
    the number that has not been seen for the longest. Numbers may be exchanged where lights pass
    each other: who needs to know which is which tells it by their places, as a constellation does.

    Parameters
    ----------
    count : int
        Greatest number of lights.
    gate_px : float
        Greatest way of a light from one sight to the next, px.
    period : int
        Frames from one sight to the next, of lights that flash; 0 of lights that do not.
    least_run : int
        Sights in a row, each a period after the one before, from which on a light is believed.

    """

    def __init__(
        self, count: int, gate_px: float, *, period: int = 0, least_run: int = 1
    ) -> None:
        self._names = numbered_lights(count)
        self._gate_px, self._period, self._least_run = gate_px, period, least_run
        self._places = [(math.inf, math.inf)] * count
        self._frames = [-math.inf] * count  # in which each was seen last
        self._runs = [0] * count

    def take(self, frame: int, candidates: Sequence[Candidate]) -> list[tuple[str, Candidate]]:
        """
        Return the lights that a frame shows and their names, in the order of their numbers.

        Parameters
        ----------
        frame : int
            Its number; each is greater than the one before.
        candidates : sequence of Candidate
            What may be lights. Of too many those of the highest SNR count.

        """
        lights = sorted(candidates, key=lambda each: -each.snr)[:len(self._names)]
        pairs = sorted(
            (away, number, index)
            for number, (x, y) in enumerate(self._places)
            for index, each in enumerate(lights)
            if (away := math.hypot(each.x - x, each.y - y)) < self._gate_px
        )
        numbers: dict[int, int] = {}  # of the lights, by their index
        for _, number, index in pairs:
            if index not in numbers and number not in numbers.values():
                numbers[index] = number
                late = frame - self._frames[number]
                self._runs[number] = self._runs[number] + 1 if late == (
                    self._period or late) else 1
        free = sorted(
            set(range(len(self._names))) - set(numbers.values()), key=self._frames.__getitem__)
        for index, number in zip(
            (index for index in range(len(lights)) if index not in numbers), free
        ):
            numbers[index] = number
            self._runs[number] = 1
        for index, number in numbers.items():
            self._places[number] = lights[index].x, lights[index].y
            self._frames[number] = frame
        return [
            (self._names[number], lights[index])
            for index, number in sorted(numbers.items(), key=lambda each: each[1])
            if self._runs[number] >= self._least_run
        ]
