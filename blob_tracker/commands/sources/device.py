"""The frames of a camera, as they come."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from blob_tracker.capture import CaptureError, Grabber, NoFrameError, V4l2Camera
from blob_tracker.commands.sources.source import Source, SourceError, SourceFrame

PATIENCE_S = 10.0  # s without a frame: there will be none


def is_device(path: Path) -> bool:
    """Tell whether a path is that of a device, or a link to one."""
    return path.is_char_device()


def open_device(
    path: Path, pixel_format: str, size: tuple[int, int] | None, frame_rate: float | None
) -> Source:
    """
    Open a V4L2 camera.

    Parameters
    ----------
    path : Path
        /dev/videoN, or a link to it.
    pixel_format : str
        Four-character code; '' leaves it to the camera.
    size : (int, int) or None
        Width and height, px; None leaves it to the camera.
    frame_rate : float or None
        Hz; None leaves it to the camera.

    Raises
    ------
    SourceError
        It cannot be opened, or does not offer what was asked for.

    """
    width, height = size or (0, 0)
    try:
        camera = V4l2Camera(
            str(path), width, height, pixel_format, frame_rate or 0.0, channel='auto'
        )
    except CaptureError as error:
        raise SourceError(str(error)) from None
    return Source(_frames(camera), stamps='the camera')


def _frames(camera: V4l2Camera) -> Iterator[SourceFrame]:
    first_ns: int | None = None
    try:
        with camera, Grabber(camera) as grabber:
            while True:
                frame = grabber.newest(PATIENCE_S)
                first_ns = frame.stamp_ns if first_ns is None else first_ns
                yield SourceFrame(f'{(frame.stamp_ns - first_ns) / 1e9:.3f} s', frame, True)
    except (NoFrameError, CaptureError) as error:
        raise SourceError(str(error)) from None
