"""Where a calibration's images come from: a folder, a bag, or a topic while the nodes run."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
import re
import time

from blob_tracker.types import Pixels
import cv2
import numpy as np

SUFFIXES = ('.bmp', '.jpeg', '.jpg', '.pgm', '.png', '.tif', '.tiff')


class SourceError(ValueError):
    """A source without usable images; the message says what is wrong and what would be right."""


def add_source(parser: argparse.ArgumentParser, what: str) -> None:
    """
    Declare SOURCE and the options that go with it.

    Parameters
    ----------
    parser : ArgumentParser
        Of the calibration.
    what : str
        What the images show, for the help: 'a board in many poses'.

    """
    parser.add_argument(
        'source',
        metavar='SOURCE',
        help=f'images of {what}: a folder, a rosbag2 folder, or a topic while the nodes run',
    )
    parser.add_argument(
        '--topic', default='camera/image_raw', help='topic of the images in a bag (%(default)s)'
    )
    parser.add_argument('--count', type=_positive_int, help='take so many frames at most')
    parser.add_argument(
        '--seconds', type=_positive_float, help='listen to a topic for so long at most'
    )


def is_folder(arguments: argparse.Namespace) -> bool:
    """Tell whether SOURCE is a folder of images, which someone chose, and no stream of them."""
    path = Path(arguments.source)
    return path.exists() and not _is_bag(path)


def is_live(arguments: argparse.Namespace) -> bool:
    """Tell whether SOURCE is the name of a topic."""
    return not Path(arguments.source).exists()


def expected(arguments: argparse.Namespace) -> int | None:
    """
    Return how many frames will come, for a progress bar; None where nobody knows.

    Raises
    ------
    SourceError
        As `frames` does.

    """
    path = Path(arguments.source)
    if is_live(arguments):
        there: int | None = None
    elif _is_bag(path):
        there = _bag_count(path, arguments.topic)
    else:
        there = len(_files(path))
    if there is None or arguments.count is None:
        return there if there is not None else arguments.count
    return min(there, arguments.count)


def frames(
    arguments: argparse.Namespace, *, interpolate: bool = True
) -> Iterator[tuple[str, Pixels]]:
    """
    Yield the frames of SOURCE by their names; else as `timed_frames`.

    Yields
    ------
    str, (h, w) uint8 or uint16 array
        A name to call the frame by, and its raw pixels; luma where it has colours.

    """
    for name, _, pixels in _named(arguments, interpolate):
        yield name, pixels


def timed_frames(
    arguments: argparse.Namespace, *, interpolate: bool = True
) -> Iterator[tuple[float | None, Pixels]]:
    """
    Yield the frames of SOURCE with their times.

    Parameters
    ----------
    arguments : Namespace
        Of a parser that `add_source` filled.
    interpolate : bool
        Whether the frames of a Bayer mosaic are interpolated to all pixels, for their places; else
        they are samples of one colour, for their noise.

    Yields
    ------
    float or None, (h, w) uint8 or uint16 array
        Time since the first, s, None in a folder; and its raw pixels, luma where it has colours.

    Raises
    ------
    SourceError
        Where there are no images, or one cannot be read.
    KeyboardInterrupt
        On Ctrl-C, from a topic as well.

    """
    for _, seconds, pixels in _named(arguments, interpolate):
        yield seconds, pixels


def _named(
    arguments: argparse.Namespace, interpolate: bool
) -> Iterator[tuple[str, float | None, Pixels]]:
    path = Path(arguments.source)
    if is_live(arguments):
        stream = _of_topic(arguments.source, arguments.seconds, interpolate)
    elif _is_bag(path):
        stream = _of_bag(path, arguments.topic, interpolate)
    else:
        stream = _of_folder(path)
    for index, frame in enumerate(stream, start=1):
        yield frame
        if index == arguments.count:
            return


def _is_bag(path: Path) -> bool:
    return (path / 'metadata.yaml').is_file() or path.suffix in ('.mcap', '.db3')


def _files(folder: Path) -> list[Path]:
    """Return the image files of a folder, view2 before view10."""
    if not folder.is_dir():
        raise SourceError(f'{folder} is a file; give the folder that holds the images')
    files = [file for file in folder.iterdir() if file.suffix.lower() in SUFFIXES]
    if not files:
        raise SourceError(f'{folder} holds no images ({" ".join(SUFFIXES)}) and is no bag')
    return sorted(
        files,
        key=lambda file: [
            (int(part), '') if part.isdigit() else (-1, part)
            for part in re.split(r'(\d+)', file.name)
        ],
    )


def _of_folder(folder: Path) -> Iterator[tuple[str, float | None, Pixels]]:
    for file in _files(folder):
        pixels = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
        if pixels is None:
            raise SourceError(f'{file} is not an image that can be read; take it out')
        if pixels.dtype not in (np.uint8, np.uint16):
            raise SourceError(f'{file} holds {pixels.dtype}; it must be 8 or 16 bits a pixel')
        if pixels.ndim == 3:
            code = cv2.COLOR_BGRA2GRAY if pixels.shape[2] == 4 else cv2.COLOR_BGR2GRAY
            pixels = cv2.cvtColor(pixels, code)
        yield file.name, None, np.asarray(pixels, dtype=pixels.dtype.type)


def _bag_count(bag: Path, topic: str) -> int:
    from blob_tracker.ros.endpoints.recording import recorded_count, RecordingError

    try:
        return recorded_count(bag, topic)
    except RecordingError as error:
        raise SourceError(str(error)) from None


def _of_bag(
    bag: Path, topic: str, interpolate: bool
) -> Iterator[tuple[str, float | None, Pixels]]:
    from blob_tracker.ros.endpoints.recording import recorded_images, RecordingError

    try:
        for seconds, pixels in recorded_images(bag, topic, interpolate=interpolate):
            yield f'{seconds:.3f} s', seconds, pixels
    except RecordingError as error:
        raise SourceError(str(error)) from None


def _of_topic(
    topic: str, longest: float | None, interpolate: bool
) -> Iterator[tuple[str, float | None, Pixels]]:
    try:
        from blob_tracker.ros.endpoints.live_images import live_images, NoImagesError
    except ImportError:
        raise SourceError(
            f"there is no folder '{topic}', and no ROS to listen to a topic of that name"
        ) from None

    began = time.monotonic()
    try:
        for seconds, pixels in live_images(topic, interpolate=interpolate):
            yield f'{seconds:.3f} s', seconds, pixels
            if longest is not None and time.monotonic() - began >= longest:
                return
    except NoImagesError as error:
        raise SourceError(str(error)) from None


def _positive_int(word: str) -> int:
    value = int(word)
    if value < 1:
        raise argparse.ArgumentTypeError(f'{word} must be 1 or more')
    return value


def _positive_float(word: str) -> float:
    value = float(word)
    if not value > 0.0:
        raise argparse.ArgumentTypeError(f'{word} must be above 0')
    return value
