"""sensor_msgs/CameraInfo to the camera model, and back."""

from __future__ import annotations

from blob_tracker.camera import CalibrationError, CameraModel
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.stamp import from_ns
from blob_tracker.types import Window
import numpy as np
from sensor_msgs.msg import CameraInfo


def to_camera_model(info: CameraInfo) -> CameraModel:
    """
    Return the camera that a camera_info describes.

    Parameters
    ----------
    info : CameraInfo
        K, D and the distortion model count; R and P belong to rectified images.

    Returns
    -------
    CameraModel
        Of the full, unbinned sensor.

    Raises
    ------
    MessageError
        Where no bearing can be computed with it, a focal length of 0 (not calibrated) included.

    """
    try:
        return CameraModel(
            width=int(info.width),
            height=int(info.height),
            matrix=np.array(info.k, dtype=float).reshape(3, 3),
            distortion=np.array(info.d, dtype=float),
            distortion_model=info.distortion_model,
        )
    except CalibrationError as error:
        raise MessageError(f'camera_info: {error}') from None


def from_camera_model(model: CameraModel | None, width: int, height: int) -> CameraInfo:
    """
    Return the camera_info of a camera that gives full frames of this size.

    Parameters
    ----------
    model : CameraModel or None
        The calibration; None leaves K at 0, which says that the camera is not calibrated.
    width, height : int
        Size of the images, px.

    Returns
    -------
    CameraInfo
        Without a stamp.

    Raises
    ------
    CalibrationError
        Where the calibration is for another size: to scale it silently could be wrong.

    """
    info = CameraInfo(width=width, height=height)
    if model is None:
        return info
    if (model.width, model.height) != (width, height):
        raise CalibrationError(
            f'the calibration is for {model.width} x {model.height} px and the camera gives '
            f'{width} x {height} px; calibrate this size or set width and height to that one'
        )
    info.distortion_model = model.distortion_model
    info.d = [float(value) for value in model.distortion]
    info.k = model.matrix.ravel()
    info.r = np.eye(3).ravel()
    info.p = np.hstack([model.matrix, np.zeros((3, 1))]).ravel()
    return info


def stamped(info: CameraInfo, stamp_ns: int, frame_id: str) -> CameraInfo:
    """Write the stamp and the optical frame into a camera_info and return it."""
    info.header.stamp = from_ns(stamp_ns)
    info.header.frame_id = frame_id
    return info


def of_window(info: CameraInfo, window: Window) -> CameraInfo:
    """Write the window's place, in full-resolution pixels (REP 104), into its camera_info."""
    height, width = window.lit.shape
    info.roi.x_offset = window.x0
    info.roi.y_offset = window.y0
    info.roi.width = width * window.binning[0]
    info.roi.height = height * window.binning[1]
    return info
