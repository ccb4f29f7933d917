"""Other lights that flash in step with the target, as its reflections do."""

from __future__ import annotations

from collections.abc import Sequence
import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.segmentation.flash_track import FlashTrack, place_of, X, Y
import numpy as np

LIKE_RATIO = 1.6  # times brighter or fainter than when it was seen beside the target


class Companions:
    """
    What flashes in step beside the target, known by where it is from it.

    Attributes
    ----------
    warning : str
        Names them; empty if there is none.
    lights : (n, 3) array
        Where each is from the target, px, and its height, DN.

    """

    def __init__(self) -> None:
        self.warning = ''
        self.lights: Array = np.empty((0, 3))

    def forget(self) -> None:
        """Know of none."""
        self.lights, self.warning = np.empty((0, 3)), ''

    def learn(self, target: FlashTrack, others: Sequence[FlashTrack]) -> None:
        """Take the lights that flash beside the target, at least one, as all that do."""
        self.lights = np.array([
            (each.x - target.x, each.y - target.y, each.height) for each in others
        ])
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


@kernel
def companion_at(
    companions: Array, target: Array, is_followed: bool, clock: Array, expected: Array,
    x: float, y: float, height: float, gate_px: float,
) -> int:
    """
    Return which of the lights beside the target one is; -1 for none.

    Parameters
    ----------
    companions : (n, 3) array
        See `Companions`.
    target : (11,) array
        As it was last seen, see `FlashTrack`.
    is_followed : bool
        Whether it is followed: then it may be where it was, or where its last speed would have it,
        as that is not known to a pixel.
    clock, expected : (15,) and (3,) arrays
        See `flash_track.reach_of`.
    x, y, height : float
        Of the light, px and DN.
    gate_px : float
        Greatest way of the target from one flash to the next, px.

    """
    there_x, there_y = target[X], target[Y]
    for _ in range(2 if is_followed else 1):
        dx, dy = x - there_x, y - there_y
        for k in range(companions.shape[0]):
            beside_x, beside_y, beside_height = companions[k]
            if (
                math.hypot(dx - beside_x, dy - beside_y) < min(gate_px, math.hypot(dx, dy))
                and beside_height < LIKE_RATIO * height
                and height < LIKE_RATIO * beside_height
            ):
                return k
        there_x, there_y = place_of(target, clock, expected)
    return -1
