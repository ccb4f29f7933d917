"""A camera that moves before a still scene with a flashing light in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from blob_tracker.simulation.flashing_light import FlashingLight, Truth
from blob_tracker.simulation.light import pixel_integrated_gaussian
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import Pixels
import cv2
import numpy as np
from numpy.typing import NDArray

MARGIN = 80  # px of wall on each side of the picture, into which the camera may move


@dataclass(frozen=True)
class MovingCamera:
    """
    A camera that steps back and forth between two poses, from the unlit to the lit frame.

    Parameters
    ----------
    scene : FlashingLight
        Wall, light and sensor; its frames are those of a camera that stands still.
    shift_x, shift_y : float
        How far the picture moves in the lit frame, px.
    turn : float
        How far it turns about its middle in the lit frame, degrees.

    """

    scene: FlashingLight
    shift_x: float = 0.0
    shift_y: float = 0.0
    turn: float = 0.0

    @property
    def motion(self) -> NDArray[np.float64]:
        """(2, 3) map from places in an unlit picture to the same places in a lit one, px."""
        middle = (0.5 * (self.scene.width - 1), 0.5 * (self.scene.height - 1))
        motion = np.array(cv2.getRotationMatrix2D(middle, self.turn, 1.0), dtype=np.float64)
        motion[:, 2] += (self.shift_x, self.shift_y)
        return motion

    def truth(self, index: int) -> Truth:
        """Return where the light is in the picture; it is on in the even frames."""
        x, y, lit = self.scene.truth(index)
        if lit:
            x, y = self.motion @ (x, y, 1.0)
        return Truth(float(x), float(y), lit)

    def frame(self, index: int) -> Pixels:
        """Return the (h, w) pixels of a frame, DN."""
        scene = self.scene
        x, y, lit = self.truth(index)
        wide = FlashingLight(
            width=scene.width + 2 * MARGIN,
            height=scene.height + 2 * MARGIN,
            background=scene.background,
            texture=scene.texture,
            seed=scene.seed,
        ).wall
        mean: NDArray[np.floating[Any]] = wide[MARGIN:-MARGIN, MARGIN:-MARGIN]
        if lit:
            motion = self.motion
            motion[:, 2] += MARGIN - motion[:, :2] @ (MARGIN, MARGIN)
            moved = cv2.warpAffine(wide, motion, wide.shape[::-1], flags=cv2.INTER_CUBIC)
            inside = np.asarray(moved, dtype=np.float64)[MARGIN:-MARGIN, MARGIN:-MARGIN]
            mean = inside + scene.amplitude * pixel_integrated_gaussian(
                (scene.height, scene.width), x, y, scene.sigma
            )
        random = np.random.Generator(np.random.SFC64([scene.seed, 1 + index]))
        return expose(mean, scene.noise, random, saturation=scene.saturation)
