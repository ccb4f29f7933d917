"""Where a calibration's images come from: a folder, a video, a bag, or a topic of a live node."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
import re
import time

from blob_tracker.ros.bags import is_bag, RecordingError
from blob_tracker.types import Pixels
import cv2
import numpy as np

VIDEOS = (
    '.avi', '.h264', '.m4v', '.mkv', '.mov', '.mp4', '.mpeg', '.mpg', '.mts', '.ts', '.webm',
    '.wmv',
)
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
        help=f'images of {what}: a folder, a video, a bag, or a topic while the nodes run',
    )
    parser.add_argument(
        '--topic', help='topic of the images in a bag (camera/image_raw, or the only one)'
    )
    parser.add_argument('--count', type=_positive_int, help='take so many frames at most')
    parser.add_argument(
        '--seconds', type=_positive_float, help='listen to a topic for so long at most'
    )


def is_folder(arguments: argparse.Namespace) -> bool:
    """Tell whether SOURCE is a folder of images, which someone chose, and no stream of them."""
    path = Path(arguments.source)
    return path.exists() and not is_bag(path) and not _is_video(path)


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
    elif is_bag(path):
        there = _bag_count(path, arguments.topic)
    elif _is_video(path):
        with _opened(path) as video:
            there = int(video.get(cv2.CAP_PROP_FRAME_COUNT))
        there = there if there > 0 else None
    else:
        there = len(_files(path))
    if there is None or arguments.count is None:
        return there if there is not None else arguments.count
    return min(there, arguments.count)


def frames(
    arguments: argparse.Namespace, *, interpolate: bool = True
) -> Iterator[tuple[str, Pixels]]:
    """
    Yield the frames of SOURCE.

    Parameters
    ----------
    arguments : Namespace
        Of a parser that `add_source` filled.
    interpolate : bool
        Whether the frames of a Bayer mosaic are interpolated to all pixels, for their places; else
        they are samples of one colour, for their noise.

    Yields
    ------
    str, (h, w) uint8 or uint16 array
        A name to call the frame by, and its raw pixels; luma where it has colours.

    Raises
    ------
    SourceError
        Where there are no images, or one cannot be read.
    KeyboardInterrupt
        On Ctrl-C, from a topic as well.

    """
    for name, _, pixels in stamped_frames(arguments, interpolate=interpolate):
        yield name, pixels


def stamped_frames(
    arguments: argparse.Namespace, *, interpolate: bool = True
) -> Iterator[tuple[str, float | None, Pixels]]:
    """
    Yield what `frames` does, with the stamp of each between name and pixels: s, or None.

    Arguments and errors are those of `frames`. A folder has no stamps; those of the others count
    from the first image.
    """
    path = Path(arguments.source)
    stream: Iterator[tuple[str, float | None, Pixels]]
    if is_live(arguments):
        stream = _of_topic(arguments.source, arguments.seconds, interpolate)
    elif is_bag(path):
        stream = _of_bag(path, arguments.topic, interpolate)
    elif _is_video(path):
        stream = _of_video(path)
    else:
        stream = _of_folder(path)
    for index, frame in enumerate(stream, start=1):
        yield frame
        if index == arguments.count:
            return


def _is_video(path: Path) -> bool:
    return path.suffix.lower() in VIDEOS and path.is_file()


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


def _of_folder(folder: Path) -> Iterator[tuple[str, None, Pixels]]:
    for file in _files(folder):
        pixels = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
        if pixels is None:
            raise SourceError(f'{file} is not an image that can be read; take it out')
        if pixels.dtype not in (np.uint8, np.uint16):
            raise SourceError(f'{file} holds {pixels.dtype}; it must be 8 or 16 bits a pixel')
        yield file.name, None, _luma(np.asarray(pixels, dtype=pixels.dtype.type))


def _luma(pixels: Pixels) -> Pixels:
    if pixels.ndim == 3:
        code = cv2.COLOR_BGRA2GRAY if pixels.shape[2] == 4 else cv2.COLOR_BGR2GRAY
        return np.asarray(cv2.cvtColor(pixels, code), dtype=pixels.dtype.type)
    return np.asarray(pixels, dtype=pixels.dtype.type)


@contextmanager
def _opened(path: Path) -> Iterator[cv2.VideoCapture]:
    video = cv2.VideoCapture(str(path))
    try:
        if not video.isOpened():
            raise SourceError(f'{path} is not a video that OpenCV can read; convert it to MJPEG')
        yield video
    finally:
        video.release()


def _of_video(path: Path) -> Iterator[tuple[str, float | None, Pixels]]:
    with _opened(path) as video:
        index, last, step = 0, 0.0, 0.0
        while True:
            there, pixels = video.read()
            if not there:
                return
            told = video.get(cv2.CAP_PROP_POS_MSEC) / 1e3  # of the frame that was read
            seconds: float | None = told
            if index and told == 0.0:
                # OpenCV 4.14 has no time for raw streams, nor for the last frames of H.264 in AVI.
                seconds = last + step if step else None
            elif index:
                step = told - last
            if seconds is not None:
                last = seconds
            name = f'frame {index}' if seconds is None else f'{seconds:.3f} s'
            yield name, seconds, _luma(np.asarray(pixels, dtype=np.uint8))
            index += 1


def _bag_count(bag: Path, topic: str | None) -> int:
    from blob_tracker.ros.endpoints.recording import recorded_count

    try:
        return recorded_count(bag, topic)
    except RecordingError as error:
        raise SourceError(str(error)) from None


def _of_bag(
    bag: Path, topic: str | None, interpolate: bool
) -> Iterator[tuple[str, float, Pixels]]:
    from blob_tracker.ros.endpoints.recording import recorded_images

    try:
        for seconds, pixels in recorded_images(bag, topic, interpolate=interpolate):
            yield f'{seconds:.3f} s', seconds, pixels
    except RecordingError as error:
        raise SourceError(str(error)) from None


def _of_topic(
    topic: str, longest: float | None, interpolate: bool
) -> Iterator[tuple[str, float, Pixels]]:
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
