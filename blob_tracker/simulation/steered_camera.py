"""A camera on a pan/tilt on a vehicle, as time goes on: it is commanded and takes pictures."""

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.simulation.gyro import Gyro
from blob_tracker.simulation.pan_tilt import PanTilt
from blob_tracker.simulation.pan_tilt_camera import PanTiltCamera
from blob_tracker.simulation.truth import Truth
from blob_tracker.types import Frame
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Felt = tuple[Array, Array]  # (n,) middles of the samples of a gyro, s, and (n, 3) rates, rad/s


class State(NamedTuple):
    """
    What encoders and gyro tell as a sample of the gyro ends.

    Parameters
    ----------
    time : float
        At which it ends, s.
    angles : (float, float)
        Pan and tilt at that time, rad.
    felt_time : float
        Middle of the sample, s.
    rate : (float, float, float)
        Angular velocity of the vehicle in the axes of the base, its mean over the sample, rad/s.

    """

    time: float
    angles: tuple[float, float]
    felt_time: float
    rate: tuple[float, float, float]


class SteeredCamera:
    """
    Drive a pan/tilt through time, and take pictures with the camera on it.

    Times are s since the ride began, and never go back. The states are of even times, those of
    the gyro, however uneven those are at which it is driven.

    Parameters
    ----------
    camera : PanTiltCamera
        What it sees.
    pan_tilt : PanTilt
        What it rides on.
    gyro : Gyro
        Of the vehicle.
    felt : Felt
        Its `samples` of the camera's ride.

    """

    def __init__(
        self, camera: PanTiltCamera, pan_tilt: PanTilt, gyro: Gyro, felt: Felt
    ) -> None:
        self.camera = camera
        self.pan_tilt = pan_tilt
        self._gyro, self._felt = gyro, felt
        self._ends = felt[0] + 0.5 / gyro.rate
        self._next = int(np.searchsorted(self._ends, pan_tilt.time, side='right'))
        self._states: list[State] = []

    def again(self) -> SteeredCamera:
        """Return the same from the beginning of the ride on; the pan/tilt stands where it is."""
        pan_tilt = PanTilt(self.pan_tilt.joints, *self.pan_tilt.angles)
        return SteeredCamera(self.camera, pan_tilt, self._gyro, self._felt)

    def advance(self, time: float) -> None:
        """Drive it up to a time, s."""
        while self._next < len(self._ends) and self._ends[self._next] <= time:
            end, middle = float(self._ends[self._next]), float(self._felt[0][self._next])
            self.pan_tilt.advance(end)
            x, y, z = self._felt[1][self._next].tolist()
            self._states.append(State(end, self.pan_tilt.reported(), middle, (x, y, z)))
            self._next += 1
        self.pan_tilt.advance(time)

    def states(self) -> list[State]:
        """Return the states since this was last asked."""
        states, self._states = self._states, []
        return states

    def picture(self, index: int, end: float) -> tuple[Frame, Truth]:
        """
        Take a picture; the light is on in even ones.

        Parameters
        ----------
        index : int
            Of the picture.
        end : float
            Of the exposure of the last row, s: it is driven up to there.

        Returns
        -------
        Frame, Truth
            The light is where it was on the mean of the exposure, of its row's.

        """
        camera, lit = self.camera, index % 2 == 0
        self.advance(end)
        first = end - 0.5 * camera.exposure - camera.readout
        times = camera.times(camera.seen(first, self.pan_tilt.at))
        x, y = camera.model.project(
            camera.rays(times, self.pan_tilt.at(times))
        ).mean(axis=0).tolist()
        frame = camera.frame(index, first, self.pan_tilt.at, lit=lit)
        return frame, Truth(x, y, lit, camera.amplitude if lit else 0.0, camera.sigma)
