"""sensor_msgs/CameraInfo to the camera model, and back."""

from __future__ import annotations

from copy import copy
from struct import Struct
from typing import TYPE_CHECKING

from blob_tracker.camera import CalibrationError, CameraModel
from blob_tracker.camera.lens import todays_name
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.serialised import begin, STAMP
from blob_tracker.ros.messages.stamp import from_ns
from blob_tracker.types import Window
import numpy as np

if TYPE_CHECKING:  # those of a bag are read where no ROS is installed, too
    from sensor_msgs.msg import CameraInfo

# x and y offset, height and width, px, and whether to rectify: the end of a message
REGION = Struct('<4I?')


class KnownCamera:
    """
    Make the camera of camera_infos, anew only if the calibration changes.

    Attributes
    ----------
    doubts : list of str
        What is unusual about it, see `CameraModel.doubts`.

    """

    def __init__(self) -> None:
        self.doubts: list[str] = []
        self._calibration: tuple[object, ...] = ()
        self._model: CameraModel | None = None

    def model(self, info: CameraInfo) -> CameraModel:
        """Return what `to_camera_model` does, and raise its errors."""
        calibration = (
            info.k.tobytes(), info.d.tobytes(), info.distortion_model, info.width, info.height
        )
        if self._model is None or calibration != self._calibration:
            self._model, self.doubts = None, []
            model = to_camera_model(info)
            try:
                self.doubts = model.doubts()
            except CalibrationError as error:
                raise MessageError(f'camera_info: {error}') from None
            self._model, self._calibration = model, calibration
        return self._model


def to_camera_model(info: CameraInfo) -> CameraModel:
    """
    Return the camera that a camera_info describes.

    Parameters
    ----------
    info : CameraInfo
        Of any crop and binning: K and D are those of the full, unbinned sensor (REP 104). R and P
        belong to rectified images and are carried along.

    Returns
    -------
    CameraModel
        Of the full, unbinned sensor.

    Raises
    ------
    MessageError
        If no bearing can be computed with it, a focal length of 0 (not calibrated) included.

    """
    try:
        return CameraModel(
            width=int(info.width),
            height=int(info.height),
            matrix=np.array(info.k, dtype=float).reshape(3, 3),
            distortion=np.array(info.d, dtype=float),
            distortion_model=todays_name(info.distortion_model),
            # All zero is how a driver leaves them that does not rectify.
            rectification=np.array(info.r).reshape(3, 3) if np.any(info.r) else None,
            projection=np.array(info.p).reshape(3, 4) if np.any(info.p) else None,
        )
    except CalibrationError as error:
        raise MessageError(f'camera_info: {error}') from None


def from_camera_model(
    model: CameraModel | None,
    width: int,
    height: int,
    *,
    x0: int = 0,
    y0: int = 0,
    binning: tuple[int, int] = (1, 1),
    sensor_size: tuple[int, int] | None = None,
) -> CameraInfo:
    """
    Return the camera_info of images of this size, crop and binning (REP 104).

    Its width, height and K are those of the full, unbinned sensor; its roi is in such pixels.

    Parameters
    ----------
    model : CameraModel or None
        The calibration; None leaves K at 0, which says that the camera is not calibrated.
    width, height : int
        Size of the images, px.
    x0, y0 : int
        Place of an image's first pixel on the sensor (`Frame.x0`, `Frame.y0`), px.
    binning : (int, int)
        Sensor pixels per image pixel along x and y (`Frame.binning`).
    sensor_size : (int, int), optional
        Width and height of the full sensor, px; where it is left out, the images reach to its
        right and lower edge.

    Returns
    -------
    CameraInfo
        Without a stamp.

    Raises
    ------
    CalibrationError
        If the calibration is for another size than the sensor's: to scale it silently could
        be wrong.

    """
    from sensor_msgs.msg import CameraInfo

    region = width * binning[0], height * binning[1]
    if sensor_size is None:
        sensor_size = x0 + region[0], y0 + region[1]
    info = CameraInfo(width=sensor_size[0], height=sensor_size[1])
    info.binning_x, info.binning_y = binning
    whole = sensor_size[0] // binning[0], sensor_size[1] // binning[1]
    if (x0, y0, width, height) != (0, 0, *whole):
        info.roi.x_offset, info.roi.y_offset = x0, y0
        info.roi.width, info.roi.height = region
    if model is None:
        return info
    if (model.width, model.height) != sensor_size:
        raise CalibrationError(_other_size(model, sensor_size, (width, height), binning))
    info.distortion_model = model.distortion_model
    info.d = [float(value) for value in model.distortion]
    info.k = model.matrix.ravel()
    info.r = model.rectification_matrix.ravel()
    info.p = model.projection_matrix.ravel()
    return info


def stamped(info: CameraInfo, stamp_ns: int, frame_id: str) -> CameraInfo:
    """Write the stamp and the optical frame into a camera_info and return it."""
    info.header.stamp = from_ns(stamp_ns)
    info.header.frame_id = frame_id
    return info


class WindowInfos:
    """Make the camera_infos of windows: all but stamp and place is most often as before."""

    def __init__(self) -> None:
        self._known: tuple[object, ...] = ()
        self._content = b''

    def serialised(self, info: CameraInfo, window: Window, frame_id: str) -> bytes:
        """Return a frame's camera_info with the window's place, full-resolution px (REP 104)."""
        known = (
            frame_id, info.k.tobytes(), info.d.tobytes(), info.r.tobytes(), info.p.tobytes(),
            info.distortion_model, info.width, info.height, info.binning_x, info.binning_y,
        )
        if known != self._known:
            self._known, self._content = known, _content(info, frame_id)
        height, width = window.lit.shape
        across, down = window.binning
        return begin(window.stamp_ns) + self._content + REGION.pack(
            window.x0, window.y0, height * down, width * across, False
        )


def _content(info: CameraInfo, frame_id: str) -> bytes:
    """Return what lies between the stamp of a serialised camera_info and its region."""
    from rclpy.serialization import serialize_message
    from sensor_msgs.msg import RegionOfInterest
    from std_msgs.msg import Header

    whole = copy(info)  # the frame's own stays as it is: a camera fills it again
    whole.header, whole.roi = Header(frame_id=frame_id), RegionOfInterest()
    content: bytes = serialize_message(whole)
    return content[STAMP.size:-REGION.size]


def _other_size(
    model: CameraModel,
    sensor_size: tuple[int, int],
    image_size: tuple[int, int],
    binning: tuple[int, int],
) -> str:
    """Say that a calibration is for another size, and what would be right."""
    sizes = (
        f'the calibration is for {model.width} x {model.height} px and the camera gives '
        f'{sensor_size[0]} x {sensor_size[1]} px'
    )
    if sensor_size == image_size:
        return (
            f'{sizes}; calibrate at {sensor_size[0]} x {sensor_size[1]} px, or set width and '
            f'height to {model.width} and {model.height}'
        )
    binned = sensor_size[0] // binning[0], sensor_size[1] // binning[1]
    if binning != (1, 1) and (model.width, model.height) == binned:
        return (
            f'the calibration is for the binned size, {model.width} x {model.height} px, and '
            f'camera_info speaks of the sensor without binning, {sensor_size[0]} x '
            f'{sensor_size[1]} px (REP 104); calibrate with binning off'
        )
    return (
        f'{sizes} without crop and binning, of which the images are {image_size[0]} x '
        f'{image_size[1]} px; calibrate the whole sensor with binning off'
    )
