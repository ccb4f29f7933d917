"""Other lights that flash in step with the target, as its reflections do."""

from __future__ import annotations

from collections.abc import Sequence
import math
from typing import NamedTuple

from blob_tracker.segmentation.flash_track import FlashTrack

LIKE_RATIO = 1.6  # times brighter or fainter than when it was seen beside the target


class Companion(NamedTuple):
    """
    A light that flashes in step beside the target.

    Parameters
    ----------
    dx, dy : float
        Where it is from the target, px.
    height : float
        DN.

    """

    dx: float
    dy: float
    height: float


class Companions:
    """
    What flashes in step beside the target, known by where it is from it.

    Attributes
    ----------
    warning : str
        Names them; empty where there is none.

    """

    def __init__(self) -> None:
        self.warning = ''
        self._lights: list[Companion] = []

    def __bool__(self) -> bool:
        """Tell whether there is any."""
        return bool(self._lights)

    def forget(self) -> None:
        """Know of none."""
        self._lights, self.warning = [], ''

    def learn(self, target: FlashTrack, others: Sequence[FlashTrack]) -> None:
        """Take the lights that flash beside the target, at least one, as all that do."""
        self._lights = [
            Companion(each.x - target.x, each.y - target.y, each.height) for each in others
        ]
        away, nearest = min(
            ((math.hypot(each.x - target.x, each.y - target.y), each) for each in others),
            key=lambda pair: pair[0],
        )
        self.warning = (
            f'{len(others) + 1} lights flash in step: the target at ({target.x:.0f}, '
            f'{target.y:.0f}) and, {away:.0f} px '
            f'away, one at ({nearest.x:.0f}, {nearest.y:.0f}): a reflection? Cover it, or set '
            'mask_url'
        )

    def like(self, dx: float, dy: float, height: float, gate_px: float) -> Companion | None:
        """Return which of them a light so far from the target is, px; None for none."""
        for each in self._lights:
            if (
                math.hypot(dx - each.dx, dy - each.dy) < min(gate_px, math.hypot(dx, dy))
                and each.height < LIKE_RATIO * height
                and height < LIKE_RATIO * each.height
            ):
                return each
        return None
