"""The image of a light: what a light must tell of itself, and how it is drawn."""

from __future__ import annotations

from math import ceil, isfinite
from typing import NamedTuple, Protocol

from blob_tracker.simulation.profiles import Gaussian, Profile
from blob_tracker.simulation.shot import Shot
from blob_tracker.simulation.truth import Truth
from blob_tracker.simulation.waveforms import mean_over, Waveform
import numpy as np
from numpy.typing import NDArray

# Each brings the time of a row nearer by the light's speed over the shutter's: 1/100 if it
# crosses the picture in a second.
ROUNDS = 5
PARTS = 16  # of an exposure, in each of which a light stands still that leaves a streak


class Spot(NamedTuple):
    """
    Where the image of a light is (px), how wide (sigma, px), and its peak (DN).

    Examples
    --------
    All of its light, 2 pi sigma^2 times its peak:

    >>> spot = Spot(x=7.3, y=6.5, sigma=2.0, amplitude=150.0)
    >>> round(2.0 * np.pi * spot.sigma**2 * spot.amplitude)  # DN
    3770

    """

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
    """
    Return what is to be found of a light in a frame.

    Examples
    --------
    A light that is never off:

    >>> from blob_tracker.simulation import Light, Scene
    >>> light = Light(40.2, 30.7, 1.5, 120.0)
    >>> truth = truth_of(light, Scene(width=80, height=60).shot(0))
    >>> truth.x, truth.y, truth.lit  # px
    (40.2, 30.7, True)

    """
    time, spot = _seen(light, shot)
    if not isfinite(time):
        return Truth(spot.x, spot.y, False)
    parts = _parts(shot)
    shares = mean_over(light.waveform, time + parts, shot.exposure / len(parts))
    share = float(shares.mean())
    lit = spot.amplitude > 0.0 and share >= 0.5
    tau = float(shares @ parts / shares.sum()) if share else 0.0
    if tau:
        there = light.spot(time + tau)
        x, y = shot.place(there.x, there.y)
        spot = there._replace(x=x, y=y)
    return Truth(spot.x, spot.y, lit, spot.amplitude * share, spot.sigma, tau)


def draw_light(light: LightSource, picture: NDArray[np.float32], shot: Shot) -> None:
    """
    Add a light to a picture; what lies beyond its border is cut off.

    It stands still within the exposure of a row, or within a part of it where it leaves a streak.
    With a rolling shutter each row has the place and the brightness of its own exposure; the light
    is slow against the shutter, and a camera that moves does so between the frames.

    Parameters
    ----------
    light : LightSource
        What to add.
    picture : (h, w) array
        Mean signal, DN; written to.
    shot : Shot
        Of the frame.

    """
    time, _ = _seen(light, shot)
    if not isfinite(time):
        return
    parts = _parts(shot)
    for later in parts.tolist():
        _draw_part(light, picture, shot, time + later, later, len(parts))


def _parts(shot: Shot) -> NDArray[np.float64]:
    """Return the middles of an exposure's parts, s from its own."""
    count = PARTS if shot.streaks else 1
    return shot.exposure * ((np.arange(count) + 0.5) / count - 0.5)


def _draw_part(
    light: LightSource,
    picture: NDArray[np.float32],
    shot: Shot,
    time: float,
    later: float,
    count: int,
) -> None:
    """Add what a light shows in one of so many parts of an exposure, so much later, s."""
    length = shot.exposure / count
    spot = light.spot(time)
    x, y = shot.place(spot.x, spot.y)
    spot = spot._replace(x=x, y=y)
    if shot.row_time == 0.0:
        share = float(mean_over(light.waveform, time, length)) / count
        spot = spot._replace(amplitude=spot.amplitude * share)
        if spot.amplitude:
            add_spot(picture, spot, light.profile, shot.aperture)
        return
    part, left, top = _about(picture, spot, light.profile)
    if not part.size:
        return
    times = later + shot.time_of(np.arange(top, top + len(part), dtype=float))
    x, y, _, amplitudes = np.array([light.spot(each) for each in times.tolist()]).T
    x, y = shot.place(x, y)
    amplitudes = amplitudes * mean_over(light.waveform, times, length) / count
    if amplitudes.any():
        part += (amplitudes[:, None] * light.profile.over_pixels(
            (part.shape[0], part.shape[1]), x - left, y - top, spot.sigma, shot.aperture
        )).astype(np.float32)


def add_spot(
    picture: NDArray[np.float32],
    spot: Spot,
    profile: Profile = Gaussian(),
    aperture: float = 1.0,
) -> None:
    """
    Add the image of a light to a picture; what lies beyond its border is cut off.

    Parameters
    ----------
    picture : (h, w) array
        Mean signal, DN; written to.
    spot : Spot
        Of the picture, px and DN.
    profile : Profile
        Its shape.
    aperture : float
        Side of the light-sensitive middle of a pixel, px.

    Examples
    --------
    A light on a wall of 40 DN:

    >>> picture = np.full((15, 15), 40.0, np.float32)
    >>> add_spot(picture, Spot(x=7.0, y=7.0, sigma=2.0, amplitude=150.0))
    >>> round(float(picture.max())), round(float(picture.min()))  # DN
    (187, 40)

    """
    part, left, top = _about(picture, spot, profile)
    if part.size:
        part += spot.amplitude * profile.over_pixels(
            (part.shape[0], part.shape[1]), spot.x - left, spot.y - top, spot.sigma, aperture
        ).astype(np.float32)


def _about(
    picture: NDArray[np.float32], spot: Spot, profile: Profile
) -> tuple[NDArray[np.float32], int, int]:
    """Return the part of a picture that a light reaches, its first column and its first row."""
    half = ceil(profile.reach * spot.sigma)
    column, row = round(spot.x), round(spot.y)
    left, top = max(column - half, 0), max(row - half, 0)
    # A stop below 0 would count from the far border.
    bottom, right = max(row + half + 1, 0), max(column + half + 1, 0)
    return picture[top:bottom, left:right], left, top


def _seen(light: LightSource, shot: Shot) -> tuple[float, Spot]:
    """Return when the row is exposed in which a light lies, s, and its image in the picture."""
    time = shot.time
    for _ in range(ROUNDS if shot.row_time else 1):
        spot = light.spot(time)
        x, y = shot.place(spot.x, spot.y)
        time = shot.time_of(y)
    return time, spot._replace(x=x, y=y)
