"""Specular glints: short, in clusters, some of them drawn out to streaks."""

from __future__ import annotations

from dataclasses import dataclass

from blob_tracker.simulation.light import REACH_SIGMA
from blob_tracker.simulation.shot import Shot
import numpy as np
from numpy.typing import NDArray

LONGEST_FRAMES = 3  # frames that a glint lasts


@dataclass(frozen=True)
class Glints:
    """
    Sun on water: groups of small bright spots that come anywhere and last 1 to 3 frames.

    Parameters
    ----------
    rate : float
        Groups a frame.
    size : float
        Glints of a group, on the mean, beside its first.
    amplitude : float
        Mean of their exponentially distributed peaks, DN.
    spread : float
        Standard deviation of their distance from the group's middle, px.
    streaks : float
        Part of them that is drawn out, to 3 to 8 times their width.
    region : (float, float, float, float)
        Left, top, right and bottom border of where groups have their middle, as parts of the
        picture's size.
    seed : int
        Of all of it.

    Examples
    --------
    Five groups in a frame, on dark water:

    >>> from blob_tracker.simulation import Scene
    >>> glints, sea = Glints(rate=5.0), np.zeros((240, 320), np.float32)
    >>> glints.draw(sea, Scene(width=320, height=240).shot(4))
    >>> sea.shape, bool(sea.max() > 10.0)  # -, DN
    ((240, 320), True)

    """

    rate: float = 0.5
    size: float = 4.0
    amplitude: float = 60.0
    spread: float = 6.0
    streaks: float = 0.25
    region: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 1.0)
    seed: int = 1

    def draw(self, picture: NDArray[np.float32], shot: Shot) -> None:
        """Add those that were born in this frame or shortly before it."""
        height, width = picture.shape
        for age in range(min(LONGEST_FRAMES, shot.index + 1)):
            random = np.random.Generator(np.random.SFC64([self.seed, shot.index - age]))
            for _ in range(random.poisson(self.rate)):
                x = width * random.uniform(self.region[0], self.region[2])
                y = height * random.uniform(self.region[1], self.region[3])
                self._draw_group(picture, random, *shot.place(x, y), age)

    def _draw_group(
        self,
        picture: NDArray[np.float32],
        random: np.random.Generator,
        x: float,
        y: float,
        age: int,
    ) -> None:
        count = 1 + random.poisson(self.size)
        # All drawn before any is left out: the same numbers at every age.
        lives = random.integers(1, LONGEST_FRAMES + 1, count)
        places = (x, y) + self.spread * random.standard_normal((count, 2))
        peaks = random.exponential(self.amplitude, count)
        sigmas = random.uniform(0.5, 1.6, count)
        drawn_out = np.where(
            random.random(count) < self.streaks, random.uniform(3.0, 8.0, count), 1.0
        )
        angles = random.uniform(0.0, np.pi, count)
        for each in np.flatnonzero(lives > age):
            _add_streak(
                picture, places[each], sigmas[each], drawn_out[each], angles[each], peaks[each]
            )


def _add_streak(
    picture: NDArray[np.float32],
    place: NDArray[np.float64],
    sigma: float,
    drawn_out: float,
    angle: float,
    peak: float,
) -> None:
    """Add a Gaussian spot, `drawn_out` times as long as it is wide, sampled in the pixels."""
    x, y = place
    reach = REACH_SIGMA * sigma * drawn_out
    height, width = picture.shape
    left, top = max(int(x - reach), 0), max(int(y - reach), 0)
    right, bottom = min(int(x + reach) + 2, width), min(int(y + reach) + 2, height)
    if left >= right or top >= bottom:
        return
    columns = np.arange(left, right) - x
    rows = (np.arange(top, bottom) - y)[:, None]
    along = (np.cos(angle) * columns + np.sin(angle) * rows) / (sigma * drawn_out)
    across = (np.cos(angle) * rows - np.sin(angle) * columns) / sigma
    picture[top:bottom, left:right] += peak * np.exp(-0.5 * (along**2 + across**2))
