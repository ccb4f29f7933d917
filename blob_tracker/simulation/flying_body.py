"""A body that flies before the camera, with lights that blink."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from blob_tracker.simulation.point_light import Light
from blob_tracker.simulation.profiles import Gaussian, Profile
from blob_tracker.simulation.scene import Scene
from blob_tracker.simulation.shot import Shot
from blob_tracker.simulation.spot import draw_light, Spot
from blob_tracker.simulation.waveforms import always, Waveform
import numpy as np
from numpy.typing import NDArray
import scipy  # which loads its parts when they are first used

Array = NDArray[np.float64]

DISTANCE_M = 1.7  # of the middle of the flight
REACH_M = np.array([0.25, 0.18, 0.3])  # from the middle, along x, y and z of the optical frame
FREQUENCIES = np.array([2.0, 3.0, 1.0])  # times in a period
PHASES = np.array([0.0, 0.5, 1.0])
# Turns of the body about its own x, y and z, that fly with it: it banks, nods and looks about.
SWING_RAD = np.array([0.25, 0.2, 0.5])


@cache
def _mean_turn() -> Any:
    """
    Return the Rotation about which a body swings.

    Its nose looks at the camera, from a little to the side and below, so that no light hides
    another: turns about x, y and z of a body that looks along the optical axis and stands upright.
    """
    turns = scipy.spatial.transform.Rotation
    upright = turns.from_matrix([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
    return upright * turns.from_euler('ZY', [2.5, 0.45])


@dataclass(frozen=True)
class Flight:
    """
    Where a body is and how it is turned, in the optical frame.

    Parameters
    ----------
    period : float
        Time after which it is at the same place again, s.

    """

    period: float = 9.0

    def pose(self, time: float) -> tuple[Array, Array]:
        """Return the (3, 3) turn from the body's frame to the optical one, and its place, m."""
        angles = 2.0 * np.pi * FREQUENCIES * time / self.period + PHASES
        place = np.array([0.0, 0.0, DISTANCE_M]) + REACH_M * np.sin(angles)
        swing = scipy.spatial.transform.Rotation.from_euler('xyz', SWING_RAD * np.cos(angles))
        turn = _mean_turn() * swing
        return np.asarray(turn.as_matrix()), place


@dataclass(frozen=True)
class BodyLight:
    """
    A light on the body.

    Parameters
    ----------
    flight : Flight
        Of the body.
    place : (3,) array
        On it, m.
    matrix : (3, 3) array
        Of the camera, which has no distortion.
    sigma, amplitude, waveform, profile
        See `Light`.

    """

    flight: Flight
    place: Array
    matrix: Array
    sigma: float
    amplitude: float
    waveform: Waveform = always
    profile: Profile = Gaussian()

    def spot(self, time: float) -> Spot:
        """Return its image at a time, px."""
        rotation, position = self.flight.pose(time)
        x, y, z = self.matrix @ (rotation @ self.place + position)
        return Spot(float(x / z), float(y / z), self.sigma, self.amplitude)

    def draw(self, picture: NDArray[np.float32], shot: Shot) -> None:
        """Add the light, see `draw_light`."""
        draw_light(self, picture, shot)


def flying_body(
    scene: Scene, lights: Mapping[str, Light], places: Mapping[str, Array], matrix: Array
) -> tuple[Scene, dict[str, BodyLight], Flight]:
    """
    Return a scene in which lights are those of a body.

    Parameters
    ----------
    scene : Scene
        With the lights by themselves, see `blinking_lights`.
    lights : mapping of str to Light
        How each blinks and looks.
    places : mapping of str to (3,) array
        Where each is on the body, m.
    matrix : (3, 3) array
        Of the camera.

    Returns
    -------
    Scene
        The same but for the lights.
    dict of str to BodyLight
        The lights by name.
    Flight
        Of the body.

    """
    flight = Flight(next(iter(lights.values())).period)
    of_body = {
        name: BodyLight(
            flight, places[name], matrix, light.sigma, light.amplitude, light.waveform,
            light.profile,
        )
        for name, light in lights.items()
    }
    return replace(scene, elements=tuple(of_body.values())), of_body, flight
