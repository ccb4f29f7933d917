"""The usual scene: a light that flashes on alternate frames and moves before a textured wall."""

from __future__ import annotations

from blob_tracker.simulation.point_light import Light
from blob_tracker.simulation.profiles import Gaussian, Profile
from blob_tracker.simulation.scene import Scene
from blob_tracker.simulation.sensor import Sensor
from blob_tracker.simulation.waveforms import in_step


def flashing_light(
    *,
    width: int = 640,
    height: int = 480,
    rate: float = 60.0,
    sigma: float = 2.0,
    amplitude: float = 150.0,
    profile: Profile = Gaussian(),
    background: float = 40.0,
    texture: float = 8.0,
    reach: float = 0.7,
    period: float = 9.0,
    sensor: Sensor = Sensor(),
    seed: int = 1,
) -> Scene:
    """
    Return a scene whose target is lit in the even frames and goes all over the picture.

    Parameters
    ----------
    width, height, rate, background, texture, sensor, seed
        See `Scene`.
    sigma, amplitude, profile, period
        See `Light`.
    reach : float
        Greatest distance of the path from the middle of the frame, as a part of its half-size.

    Examples
    --------
    A light that is on in the even frames, and how much brighter it makes its pixel:

    >>> scene = flashing_light(width=160, height=120)
    >>> truth = scene.truth(0)
    >>> row, column = round(truth.y), round(truth.x)
    >>> lit, unlit = (int(scene.frame(index)[row, column]) for index in (0, 1))
    >>> truth.lit, round(lit - unlit, -1)  # -, DN
    (True, 140)

    """
    target = Light(
        0.5 * (width - 1),
        0.5 * (height - 1),
        sigma,
        amplitude,
        in_step(rate),
        reach_x=reach * 0.5 * width,
        reach_y=reach * 0.5 * height,
        period=period,
        profile=profile,
    )
    return Scene(
        target,
        width=width,
        height=height,
        rate=rate,
        background=background,
        texture=texture,
        sensor=sensor,
        seed=seed,
    )
