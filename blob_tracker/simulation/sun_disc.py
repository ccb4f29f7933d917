"""The sun in the picture: a clipped disc in its glare."""

from __future__ import annotations

from dataclasses import dataclass

from blob_tracker.simulation.shot import Shot
import numpy as np
from numpy.typing import NDArray

LIMB_PX = 1.0  # px over which the disc's edge falls


@dataclass(frozen=True)
class SunDisc:
    """
    A disc far above full scale, and glare about it that falls with the square of the distance.

    Parameters
    ----------
    x, y : float
        Its centre, px of the scene.
    radius : float
        px.
    level : float
        Brightness of the disc, DN.
    glare : float
        Brightness at the disc's edge, DN.

    Examples
    --------
    Its middle, far above full scale, and its glare two radii from there:

    >>> from blob_tracker.simulation import Scene
    >>> picture = np.zeros((240, 320), np.float32)
    >>> SunDisc(160.0, 120.0).draw(picture, Scene(width=320, height=240).shot(0))
    >>> round(float(picture[120, 160])), round(float(picture[120, 184]))  # DN
    (5059, 14)

    """

    x: float
    y: float
    radius: float = 12.0
    level: float = 5000.0
    glare: float = 60.0

    def draw(self, picture: NDArray[np.float32], shot: Shot) -> None:
        """Add disc and glare, out to where the glare is a fiftieth of what it is at the edge."""
        x, y = shot.place(self.x, self.y)
        height, width = picture.shape
        reach = 7.0 * self.radius
        left, top = max(int(x - reach), 0), max(int(y - reach), 0)
        right, bottom = min(int(x + reach) + 2, width), min(int(y + reach) + 2, height)
        if left >= right or top >= bottom:
            return
        columns = (np.arange(left, right) - x).astype(np.float32)
        rows = (np.arange(top, bottom) - y).astype(np.float32)[:, None]
        square = (columns**2 + rows**2) / np.float32(self.radius**2)
        inside = (self.radius * (1.0 - np.sqrt(square)) / LIMB_PX + 0.5).clip(0.0, 1.0)
        # Less what it is at the border, so that it ends there without an edge.
        falling = (1.0 / np.maximum(square, 1.0) - 1.0 / 49.0).clip(0.0)
        picture[top:bottom, left:right] += self.glare * falling + self.level * inside
