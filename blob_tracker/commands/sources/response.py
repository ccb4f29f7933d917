"""The camera's response, by which frames are made linear before they are measured."""

from __future__ import annotations

import argparse
from pathlib import Path

from blob_tracker.camera import CalibrationError
from blob_tracker.camera.response import Response
from blob_tracker.commands.sources.source import SourceError
from blob_tracker.types import Frame, Pixels
import numpy as np


def add_response(parser: argparse.ArgumentParser) -> None:
    """Declare the option."""
    parser.add_argument(
        '--response', type=Path, metavar='FILE',
        help='make the pixels linear by it first: what calibrate response wrote',
    )


def response_of(arguments: argparse.Namespace) -> Response | None:
    """Return the response that makes the frames linear; None if they stay as they are."""
    if arguments.response is None:
        return None
    try:
        return Response.from_yaml(arguments.response)
    except CalibrationError as error:
        raise SourceError(str(error)) from None


def clipping_level(response: Response | None, saturation: int | None, pixels: Pixels) -> int:
    """Return the DN at which a frame's pixels are clipped, by --saturation, in raw DN."""
    if response is not None:
        return response.linear_saturation(saturation or response.saturation)
    return saturation or int(np.iinfo(pixels.dtype).max)


def linear_frame(frame: Frame, sensor: tuple[int, int], response: Response) -> Frame:
    """Return a frame in linear DN, or raise SourceError where the response is of other ones."""
    try:
        response.check_size(*sensor)
        return response.linear_frame(frame)
    except CalibrationError as error:
        raise SourceError(str(error)) from None
