"""The image of a light: what a light must tell of itself, and how it is drawn."""

from __future__ import annotations

from math import ceil, isfinite
from typing import NamedTuple, Protocol

from blob_tracker.simulation.profiles import Profile
from blob_tracker.simulation.shot import Shot
from blob_tracker.simulation.truth import Truth
from blob_tracker.simulation.waveforms import mean_over, Waveform
import numpy as np
from numpy.typing import NDArray

# Each brings the time of a row nearer by the light's speed over the shutter's: 1/100 if it
# crosses the picture in a second.
ROUNDS = 5


class Spot(NamedTuple):
    """Where the image of a light is (px), how wide (sigma, px), and its peak (DN)."""

    x: float
    y: float
    sigma: float
    amplitude: float


class LightSource(Protocol):
    """A light of any kind."""

    @property
    def waveform(self) -> Waveform:
        """How bright it is at a time, in parts of its amplitude."""

    @property
    def profile(self) -> Profile:
        """Shape of its image."""

    def spot(self, time: float) -> Spot:
        """Return its image at a time, px of the scene; NaN where it has none."""

    def draw(self, picture: NDArray[np.float32], shot: Shot) -> None:
        """Add it to the (h, w) mean signal of the picture, DN."""


def truth_of(light: LightSource, shot: Shot) -> Truth:
    """Return what is to be found of a light in a frame."""
    time, spot = _seen(light, shot)
    if not isfinite(time):
        return Truth(spot.x, spot.y, False)
    brightness = float(mean_over(light.waveform, time, shot.exposure))
    lit = spot.amplitude > 0.0 and brightness >= 0.5
    return Truth(spot.x, spot.y, lit, spot.amplitude * brightness, spot.sigma)


def draw_light(light: LightSource, picture: NDArray[np.float32], shot: Shot) -> None:
    """
    Add a light to a picture; what lies beyond its border is cut off.

    It stands still within the exposure of a row. With a rolling shutter each row has the place
    and the brightness of its own exposure; the light is slow against the shutter, and a camera
    that moves does so between the frames.

    Parameters
    ----------
    light : LightSource
        What to add.
    picture : (h, w) array
        Mean signal, DN; written to.
    shot : Shot
        Of the frame.

    """
    time, spot = _seen(light, shot)
    if not isfinite(time):
        return
    half = ceil(light.profile.reach * spot.sigma)
    column, row = round(spot.x), round(spot.y)
    left, top = max(column - half, 0), max(row - half, 0)
    # A stop below 0 would count from the far border.
    bottom, right = max(row + half + 1, 0), max(column + half + 1, 0)
    part = picture[top:bottom, left:right]
    if not part.size:
        return
    shape = (part.shape[0], part.shape[1])
    if shot.row_time == 0.0:
        amplitude = spot.amplitude * float(mean_over(light.waveform, time, shot.exposure))
        if amplitude:
            part += amplitude * light.profile.over_pixels(
                shape, spot.x - left, spot.y - top, spot.sigma, shot.aperture
            ).astype(np.float32)
        return
    times = shot.time_of(np.arange(top, top + len(part), dtype=float))
    x, y, _, amplitudes = np.array([light.spot(each) for each in times.tolist()]).T
    x, y = shot.place(x, y)
    amplitudes = amplitudes * mean_over(light.waveform, times, shot.exposure)
    if amplitudes.any():
        part += (amplitudes[:, None] * light.profile.over_pixels(
            shape, x - left, y - top, spot.sigma, shot.aperture
        )).astype(np.float32)


def _seen(light: LightSource, shot: Shot) -> tuple[float, Spot]:
    """Return when the row is exposed in which a light lies, s, and its image in the picture."""
    time = shot.time
    for _ in range(ROUNDS if shot.row_time else 1):
        spot = light.spot(time)
        x, y = shot.place(spot.x, spot.y)
        time = shot.time_of(y)
    return time, spot._replace(x=x, y=y)
