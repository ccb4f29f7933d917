"""What each reader of frames returns."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
from types import ModuleType
from typing import Any, NamedTuple

from blob_tracker.camera import CameraModel
from blob_tracker.types import Frame, Pixels
import numpy as np
from numpy.typing import NDArray

COLOURS = {3: 'rgb', 4: 'rgba'}  # by their number, as all but OpenCV order them


class SourceError(ValueError):
    """A source without usable images; the message says what is wrong and what would be right."""


class SourceFrame(NamedTuple):
    """
    A frame of a source.

    Parameters
    ----------
    name : str
        To call it by: a file, a page, a time.
    frame : Frame
        Its stamp counts from any instant.
    stamped : bool
        Whether it has a stamp.
    sensor : (int, int) or None
        Width and height of the full, unbinned sensor, px, where the source tells them.

    """

    name: str
    frame: Frame
    stamped: bool
    sensor: tuple[int, int] | None = None


class GreyFrame(NamedTuple):
    """
    A frame of a source without its colours.

    Parameters
    ----------
    name : str
        To call it by.
    seconds : float or None
        Its stamp in s since the first frame's; None if it has none.
    pixels : (h, w) uint8 or uint16 array
        DN; luma where it had colours.
    sensor : (int, int)
        Width and height of the full, unbinned sensor, px, as far as the source tells.

    """

    name: str
    seconds: float | None
    pixels: Pixels
    sensor: tuple[int, int]


@dataclass(frozen=True)
class Source:
    """
    An open source of frames.

    Parameters
    ----------
    frames : iterable of SourceFrame
        In their order; errors of reading are raised on the way.
    count : int or None
        How many there will be, where that is known.
    stamps : str
        Where their stamps are from, in words; '' where they have none.
    camera_model : CameraModel or None
        The calibration that the source has of its own.
    uncalibrated : str
        Why there is none, where it should be there.

    """

    frames: Iterable[SourceFrame]
    count: int | None = None
    stamps: str = ''
    camera_model: CameraModel | None = None
    uncalibrated: str = ''


def reach(frame: Frame) -> tuple[int, int]:
    """Return how far a frame reaches on the sensor, px: its size, where no one tells that."""
    height, width = frame.image.shape[:2]
    return frame.x0 + width * frame.binning[0], frame.y0 + height * frame.binning[1]


def library(name: str, what: str) -> ModuleType:
    """Return the library that reads a format, or say how to install it."""
    try:
        return import_module(name)
    except ImportError:
        package = name.partition('.')[0]
        raise SourceError(
            f'{what} are read by {package}, which is not installed: python3 -m pip install '
            f'{package}'
        ) from None


def frame_of(
    pixels: NDArray[Any], where: str, stamp_ns: int | None = None, layout: str = ''
) -> SourceFrame:
    """
    Return the frame of pixels of any type, and refuse those that are no DN.

    Parameters
    ----------
    pixels : (h, w) or (h, w, n) array
        Whole numbers of 8 or 16 bits; signed ones from 0 on.
    where : str
        Name of the frame.
    stamp_ns : int, optional
        Middle of the exposure, ns; None if it is not known.
    layout : str
        See `Frame`; '' is grey, or by the number of colours.

    Raises
    ------
    SourceError
        They are of another kind.

    """
    found: Pixels
    if pixels.dtype.kind == 'i' and pixels.itemsize == 2 and pixels.size and pixels.min() >= 0:
        found, full = pixels.astype(np.uint16), 2**15 - 1
    elif pixels.dtype.kind == 'u' and pixels.itemsize <= 2:
        found = np.ascontiguousarray(pixels, pixels.dtype.newbyteorder('='))
        full = 2 ** (8 * pixels.itemsize) - 1
    else:
        raise SourceError(
            f'{where} holds {pixels.dtype.newbyteorder("=")}; it must be 8 or 16 bits a pixel, '
            '0 or more'
        )
    layout = layout or ('grey' if found.ndim == 2 else COLOURS.get(found.shape[-1], ''))
    try:
        frame = Frame(found, stamp_ns or 0, full, layout=layout)
    except ValueError as error:
        raise SourceError(f'{where}: {error}') from None
    return SourceFrame(where, frame, stamp_ns is not None)
