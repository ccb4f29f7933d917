"""A camera on a pan/tilt on a vehicle, as time goes on: it is commanded and takes pictures."""

from __future__ import annotations

from blob_tracker.simulation.pan_tilt import PanTilt
from blob_tracker.simulation.pan_tilt_camera import PanTiltCamera
from blob_tracker.simulation.truth import Truth
from blob_tracker.types import Frame
import numpy as np
from numpy.typing import NDArray


class SteeredCamera:
    """
    Drive a pan/tilt through time, and take pictures with the camera on it.

    Times are s since the ride began, and never go back.

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

    def rate(self, time: float) -> NDArray[np.float64]:
        """Return the (3,) angular velocity of the vehicle in the axes of the base, rad/s."""
        return np.asarray(self.camera.ride.rates(np.array([time]))[0])

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
            self.pan_tilt.advance(time)
            joints[row] = self.pan_tilt.angles
        x, y = camera.model.project(camera.rays(times, joints)).mean(axis=0).tolist()
        frame = camera.frame(index, middle, joints, lit=lit)
        return frame, Truth(x, y, lit, camera.amplitude if lit else 0.0, camera.sigma)
