"""sensor_msgs/CompressedImage to frames: JPEG, PNG and whatever else OpenCV reads."""

from __future__ import annotations

from typing import TYPE_CHECKING

from blob_tracker.capture.pixel_formats.jpeg import extent, luma_quantisation
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.image import placed, stamp_of
from blob_tracker.types import BAYER, Frame, FULL_SCALE_DN
import numpy as np

if TYPE_CHECKING:  # those of a bag are read where no ROS is installed, too
    from sensor_msgs.msg import CameraInfo, CompressedImage

JPEG = b'\xff\xd8'
MOST_PIXELS = 1 << 28  # of a JPEG: a damaged size must not fill the memory
PNG = b'\x89PNG'
DEPTH_HEADER = 12  # bytes of compressed_depth_image_transport before its PNG
_LAYOUTS = {1: 'grey', 3: 'bgr', 4: 'bgra'}  # of what OpenCV decodes, by its planes


def to_frame(message: CompressedImage, info: CameraInfo) -> Frame:
    """
    Return the frame of a compressed image with the crop and binning of its camera_info.

    Raises
    ------
    MessageError
        As of `to_whole_frame`, or where the camera_info is that of another size.

    """
    return placed(to_whole_frame(message), info)


def to_whole_frame(message: CompressedImage) -> Frame:
    """
    Return the frame of a compressed image without its camera_info.

    Parameters
    ----------
    message : CompressedImage
        Of rclpy or of rosbags. Its format, as image_transport writes it, begins with the encoding
        of the image before it was compressed, of which the filters of a mosaic are taken; the
        rest is told by the data.

    Returns
    -------
    Frame
        With the stamp of the message, and of a JPEG with the steps in which its luma is kept.

    Raises
    ------
    MessageError
        If a JPEG or PNG is damaged, or the data are no picture of 8 or 16 bits.

    """
    import cv2  # no part of a start

    data = np.frombuffer(message.data, np.uint8)
    if data[DEPTH_HEADER:DEPTH_HEADER + len(PNG)].tobytes() == PNG:
        data = data[DEPTH_HEADER:]
    quantisation = None
    if data[:len(JPEG)].tobytes() == JPEG:
        try:
            _, size = extent(data.tobytes())
            if size is not None and size[0] * size[1] > MOST_PIXELS:
                raise ValueError(f'the JPEG claims to be {size[0]}x{size[1]}')
            quantisation = luma_quantisation(data.tobytes())
        except ValueError as error:
            raise MessageError(str(error)) from None
    pixels = cv2.imdecode(data, cv2.IMREAD_UNCHANGED) if data.size else None
    if pixels is None and data[:len(PNG)].tobytes() == PNG:
        raise MessageError(f'the PNG is cut short or damaged: {data.size} bytes')
    if pixels is None:
        raise MessageError(
            f'{data.size} bytes of format {message.format!r:.40} are not a picture that OpenCV '
            'decodes; record JPEG or PNG, or the raw images'
        )
    if pixels.dtype not in (np.uint8, np.uint16):
        raise MessageError(f'the picture holds {pixels.dtype}; it must be 8 or 16 bits a pixel')
    layout = _LAYOUTS[1 if pixels.ndim == 2 else pixels.shape[2]]
    encoding = message.format.lower().partition(';')[0].strip()
    if 'compressed rgb' in message.format:  # what was compressed as if it were bgr
        layout = {'bgr': 'rgb', 'bgra': 'rgba'}.get(layout, layout)
    if layout == 'grey' and encoding.startswith('bayer_') and encoding[6:10] in BAYER:
        layout = encoding[6:10]
    image = np.asarray(pixels, np.uint8 if pixels.dtype == np.uint8 else np.uint16)
    return Frame(
        image, stamp_of(message), FULL_SCALE_DN[image.dtype], layout=layout,
        quantisation=quantisation,
    )
