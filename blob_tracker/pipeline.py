"""The rooms in a row for one target: frames in, bearings out, no ROS."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from blob_tracker.camera import CameraModel
from blob_tracker.location import locate
from blob_tracker.segmentation import Segmenter
from blob_tracker.types import Bearing, Frame, LocationError, SensorNoise


class Pipeline:
    """
    Track one flashing light.

    Parameters
    ----------
    camera_model : CameraModel
        The calibrated camera.
    noise : SensorNoise
        Gain and read noise of its pixels.
    method : str
        Location method, a key of `blob_tracker.location.METHODS`.
    segmenter : Segmenter, optional
        Finds the flash; one with default settings where it is left out.

    """

    def __init__(
        self,
        camera_model: CameraModel,
        *,
        noise: SensorNoise,
        method: str = 'maximum_likelihood',
        segmenter: Segmenter | None = None,
    ) -> None:
        self.camera_model = camera_model
        self.noise = noise
        self.method = method
        self.segmenter = segmenter or Segmenter()

    def run(self, frames: Iterable[Frame]) -> Iterator[Bearing]:
        """
        Yield a bearing for each frame in which the target lit up and could be placed.

        Parameters
        ----------
        frames : iterable of Frame
            In the order of their stamps.

        Yields
        ------
        Bearing
            With the stamp of its lit frame.

        Raises
        ------
        FrameError
            Where a frame cannot follow the one before it.

        """
        for frame in frames:
            window = self.segmenter.update(frame)
            if window is None:
                continue
            try:
                location = locate(window, method=self.method, noise=self.noise)
            except LocationError:
                continue  # silence, never a wrong angle
            yield self.camera_model.bearing(location)
