"""Something brighter or darker than the wall that passes: its edges rise and fall."""

from __future__ import annotations

from dataclasses import dataclass

from blob_tracker.simulation.shot import Shot
import numpy as np
from numpy.typing import NDArray
import scipy  # which loads special, 20 MB, when it is first used

MARGIN_PX = 20.0  # px beyond the border at which it comes in again


@dataclass(frozen=True)
class PassingObject:
    """
    A rectangle with soft edges that moves at a constant speed and comes round again.

    Parameters
    ----------
    x, y : float
        Its centre in frame 0, px of the scene.
    width, height : float
        Its size, px.
    level : float
        Its brightness, DN; it hides what is behind it.
    speed_x, speed_y : float
        px a frame.
    blur : float
        Standard deviation of its edges, px.

    Examples
    --------
    A dark bird that has gone 30 px to the right in ten frames:

    >>> from blob_tracker.simulation import Scene
    >>> bird = PassingObject(60.0, 60.0, width=12.0, height=4.0, level=20.0, speed_x=3.0)
    >>> picture = np.full((120, 160), 40.0, np.float32)
    >>> bird.draw(picture, Scene(width=160, height=120).shot(10))
    >>> round(float(picture[60, 90])), round(float(picture[60, 60]))  # DN
    (20, 40)

    """

    x: float
    y: float
    width: float
    height: float
    level: float
    speed_x: float
    speed_y: float = 0.0
    blur: float = 0.7

    def draw(self, picture: NDArray[np.float32], shot: Shot) -> None:
        """Put it over what is there."""
        height, width = picture.shape
        x, y = shot.place(
            _around(self.x + self.speed_x * shot.index, width, self.width),
            _around(self.y + self.speed_y * shot.index, height, self.height),
        )
        left, across = _cover(x, self.width, self.blur, width)
        top, down = _cover(y, self.height, self.blur, height)
        part = picture[top:top + len(down), left:left + len(across)]
        part += (down[:, None] * across) * (np.float32(self.level) - part)


def _around(place: float, side: int, size: float) -> float:
    """Return the place of what leaves on one side and comes in on the other."""
    beyond = 0.5 * size + MARGIN_PX
    return (place + beyond) % (side + 2.0 * beyond) - beyond


def _cover(
    place: float, size: float, blur: float, side: int
) -> tuple[int, NDArray[np.float32]]:
    """Return the first pixel that it touches and how far it covers each from there on."""
    reach = 0.5 * size + 5.0 * blur + 1.0
    first = int(np.clip(np.floor(place - reach), 0, side))
    last = int(np.clip(np.ceil(place + reach), 0, side))
    pixels = np.arange(first, last) - place
    scale = np.sqrt(2.0) * blur
    edges = np.array([pixels + 0.5 * size, pixels - 0.5 * size])
    cover = 0.5 * -np.diff(scipy.special.erf(edges / scale), axis=0)[0]
    return first, cover.astype(np.float32)
