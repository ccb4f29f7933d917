"""A camera on a pan/tilt on a vehicle, as time goes on: it is commanded and takes pictures."""

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.simulation.pan_tilt import PanTilt
from blob_tracker.simulation.pan_tilt_camera import PanTiltCamera
from blob_tracker.simulation.truth import Truth
from blob_tracker.types import Frame
import numpy as np

STATES = 200.0  # a second


class State(NamedTuple):
    """
    What encoders and gyro tell of an instant.

    Parameters
    ----------
    time : float
        s.
    angles : (float, float)
        Pan and tilt, rad.
    rate : (float, float, float)
        Angular velocity of the vehicle in the axes of the base, rad/s.

    """

    time: float
    angles: tuple[float, float]
    rate: tuple[float, float, float]


class SteeredCamera:
    """
    Drive a pan/tilt through time, and take pictures with the camera on it.

    Times are s since the ride began, and never go back. The states are of even times, however
    uneven those are at which it is driven.

    Parameters
    ----------
    camera : PanTiltCamera
        What it sees.
    pan_tilt : PanTilt
        What it rides on.

    """

    def __init__(self, camera: PanTiltCamera, pan_tilt: PanTilt) -> None:
        self.camera = camera
        self.pan_tilt = pan_tilt
        self._states: list[State] = []
        self._count = 0

    def advance(self, time: float) -> None:
        """Drive it up to a time, s."""
        while self._count / STATES <= time:
            at = self._count / STATES
            self.pan_tilt.advance(at)
            x, y, z = self.camera.ride.rates(np.array([at]))[0].tolist()
            self._states.append(State(at, self.pan_tilt.reported(), (x, y, z)))
            self._count += 1
        self.pan_tilt.advance(time)

    def states(self) -> list[State]:
        """Return the states since this was last asked."""
        states, self._states = self._states, []
        return states

    def picture(self, index: int, begin: float) -> tuple[Frame, Truth]:
        """
        Take a picture; the light is on in even ones.

        Parameters
        ----------
        index : int
            Of the picture.
        begin : float
            Of the exposure, s.

        Returns
        -------
        Frame, Truth
            The light is where it was on the mean of the exposure.

        """
        camera, lit = self.camera, index % 2 == 0
        middle = begin + 0.5 * camera.exposure
        times = camera.times(middle)
        joints = np.empty((len(times), 2))
        for row, time in enumerate(times.tolist()):
            self.advance(time)
            joints[row] = self.pan_tilt.angles
        x, y = camera.model.project(camera.rays(times, joints)).mean(axis=0).tolist()
        frame = camera.frame(index, middle, joints, lit=lit)
        return frame, Truth(x, y, lit, camera.amplitude if lit else 0.0, camera.sigma)
