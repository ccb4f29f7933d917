"""A light: a target, a lamp, a reflection."""

from __future__ import annotations

from dataclasses import dataclass

from blob_tracker.simulation.light import add_pulse
from blob_tracker.simulation.shot import Shot
from blob_tracker.simulation.waveforms import always, mean_over, Waveform
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
        Time in which it goes across and back, s.

    """

    x: float
    y: float
    sigma: float
    amplitude: float
    waveform: Waveform = always
    reach_x: float = 0.0
    reach_y: float = 0.0
    period: float = 9.0

    def place(self, time: float) -> tuple[float, float]:
        """
        Return where it is, px of the scene.

        The path is a Lissajous figure of the frequencies 2 and 3, which goes in all directions
        and visits every sub-pixel phase.
        """
        angle = 2.0 * np.pi * time / self.period
        x = self.x + self.reach_x * np.sin(2.0 * angle)
        y = self.y + self.reach_y * np.sin(3.0 * angle + 0.5)
        return float(x), float(y)

    def brightness(self, shot: Shot) -> float:
        """Return the mean of its waveform over an exposure."""
        return mean_over(self.waveform, shot.time, shot.exposure)

    def draw(self, picture: NDArray[np.float32], shot: Shot) -> None:
        """Add the light; it stands still within an exposure."""
        amplitude = self.amplitude * self.brightness(shot)
        if amplitude:
            add_pulse(picture, *shot.place(*self.place(shot.time)), self.sigma, amplitude)
