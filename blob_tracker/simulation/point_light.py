"""A light in the picture: a target, a lamp, a reflection."""

from __future__ import annotations

from dataclasses import dataclass

from blob_tracker.simulation.profiles import Gaussian, Profile
from blob_tracker.simulation.shot import Shot
from blob_tracker.simulation.spot import draw_light, Spot
from blob_tracker.simulation.waveforms import always, Waveform
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Light:
    """
    A light, as bright in a frame as it was on the mean of the exposure.

    Parameters
    ----------
    x, y : float
        Place, or the middle of its path, px of the scene.
    sigma : float
        Standard deviation of its image, px.
    amplitude : float
        Peak above the background where its waveform is 1 for the whole exposure, DN.
    waveform : callable
        From times, s, to parts of the amplitude, see `waveforms`.
    reach_x, reach_y : float
        Greatest distance of its path from the middle, px.
    period : float
        Time of its path, s: twice across and back, and three times up and down.
    start : float
        Where on its path it begins, as a part of it.
    profile : Profile
        Shape of its image, see `profiles`.

    Examples
    --------
    A light that swings by 20 px, twice in 9 s, and is on in every other frame:

    >>> from blob_tracker.simulation import in_step
    >>> light = Light(80.0, 60.0, 1.5, 120.0, in_step(60.0), reach_x=20.0)
    >>> [round(light.spot(time).x, 1) for time in (0.0, 1.125, 3.375)]  # px
    [80.0, 100.0, 60.0]

    """

    x: float
    y: float
    sigma: float
    amplitude: float
    waveform: Waveform = always
    reach_x: float = 0.0
    reach_y: float = 0.0
    period: float = 9.0
    start: float = 0.0
    profile: Profile = Gaussian()

    def spot(self, time: float) -> Spot:
        """
        Return its image at a time, px of the scene.

        The path is a Lissajous figure of the frequencies 2 and 3, which goes in all directions
        and visits every sub-pixel phase.
        """
        angle = 2.0 * np.pi * (time / self.period + self.start)
        x = self.x + self.reach_x * np.sin(2.0 * angle)
        y = self.y + self.reach_y * np.sin(3.0 * angle + 0.5)
        return Spot(float(x), float(y), self.sigma, self.amplitude)

    def draw(self, picture: NDArray[np.float32], shot: Shot) -> None:
        """Add the light, see `draw_light`."""
        draw_light(self, picture, shot)
