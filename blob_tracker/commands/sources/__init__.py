"""
Where frames come from: one place that opens them, for `track` and for all calibrations.

A folder of images, a TIFF, a FITS, a video, a raw dump, a bag, a camera, or a topic of a live
node: one file for each, by its library. `open_source` finds the one.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path
import re
import time

from blob_tracker.camera.response import Response
from blob_tracker.colour import grey_pixels
from blob_tracker.commands.exit_code import UsageError
from blob_tracker.commands.sources import fits, tiff, video
from blob_tracker.commands.sources.bag import open_bag
from blob_tracker.commands.sources.device import is_device, open_device
from blob_tracker.commands.sources.folder import open_folder, SUFFIXES
from blob_tracker.commands.sources.raw import open_raw
from blob_tracker.commands.sources.response import add_response, linear_frame
from blob_tracker.commands.sources.source import (
    GreyFrame, reach, Source, SourceError, SourceFrame,
)
from blob_tracker.commands.sources.topic import open_topic
from blob_tracker.ros.bags import is_bag

__all__ = [
    'add_source', 'grey_frames', 'GreyFrame', 'is_folder', 'is_live', 'is_topic', 'open_source',
    'reach', 'Source', 'SourceError', 'SourceFrame', 'unstamped',
]

# As ROS has them (https://design.ros2.org/articles/topic_and_service_names.html): of a file the
# name mostly has a point.
TOPIC = re.compile(r'~?/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*', re.ASCII)
# Formats of frames that no maintained library reads: what to make of them.
UNREAD = {
    '.ser': 'export it from Siril or SER Player as a FITS cube, or as a folder of 16-bit TIFF or '
            'PNG',
    '.cine': 'export it from PCC (Phantom) as a 16-bit TIFF stack',
    '.seq': 'export it from the program that recorded it as a 16-bit TIFF stack',
    '.gif': 'its colours were chosen again, and light is no longer in proportion; record a video',
}


def add_source(
    parser: argparse.ArgumentParser, what: str, *, topics: bool = True, response: bool = True
) -> None:
    """
    Declare SOURCE and the options that go with it.

    Parameters
    ----------
    parser : ArgumentParser
        Of the command.
    what : str
        What the images show, for the help: 'a board in many poses'.
    topics : bool
        Whether it may be the topic of a live node.
    response : bool
        Whether its pixels may be made linear first, by --response.

    """
    live = ', a topic while the nodes run' if topics else ''
    parser.add_argument(
        'source',
        metavar='SOURCE',
        help=f'images of {what}: a folder of them, a video, a TIFF or OME-TIFF, a FITS, a raw '
        f'dump, a bag{live}, or a camera (/dev/video0)',
    )
    parser.add_argument(
        '--topic', help='topic of the images in a bag (camera/image_raw, or the only one)'
    )
    parser.add_argument('--count', type=_positive_int, help='take so many frames at most')
    parser.add_argument(
        '--seconds', type=_positive_float,
        help=f'take a camera{" or a topic" if topics else ""} for so long at most',
    )
    parser.add_argument(
        '--frame-rate', type=_positive_float, metavar='HZ',
        help='frames a second, if the source has no stamps, or wrong ones; of a camera the '
        'one that it is set to',
    )
    parser.add_argument(
        '--pixel-format', default='', metavar='CODE',
        help='of a raw dump, or of a camera: GREY, Y12P, RG10 ... as V4L2 names them',
    )
    parser.add_argument(
        '--size', type=_size, metavar='WxH', help='of a raw dump, or of a camera, px: 640x480'
    )
    parser.add_argument(
        '--stride', type=_positive_int, default=0, metavar='BYTES',
        help='from line to line of a raw dump, if lines are padded',
    )
    if response:
        add_response(parser)
    else:
        parser.set_defaults(response=None)


def is_folder(arguments: argparse.Namespace) -> bool:
    """Tell whether SOURCE is a folder of images, which someone chose, and no stream of them."""
    path = Path(arguments.source)
    return path.is_dir() and not is_bag(path)


def is_topic(arguments: argparse.Namespace) -> bool:
    """Tell whether SOURCE is the name of a topic: it may be, and there is no such file."""
    path = Path(arguments.source)
    return bool(TOPIC.fullmatch(arguments.source)) and not (path.exists() or is_device(path))


def is_live(arguments: argparse.Namespace) -> bool:
    """Tell whether SOURCE does not end by itself: a topic or a camera."""
    return is_topic(arguments) or is_device(Path(arguments.source))


def open_source(
    arguments: argparse.Namespace, *, calibrated: bool = False, woven: bool = False
) -> Source:
    """
    Open SOURCE.

    Parameters
    ----------
    arguments : Namespace
        Of a parser that `add_source` filled.
    calibrated : bool
        Whether the calibration is wanted that a bag has, see `open_bag`.
    woven : bool
        Whether the fields that a camera node publishes one by one are put together to pictures.

    Returns
    -------
    Source
        --count, --seconds and --frame-rate taken into account.

    Raises
    ------
    SourceError
        If there are no images, or they cannot be read; also while they are.
    UsageError
        If there is no such source, or it does not use an option that is given.

    """
    path, rate = Path(arguments.source), arguments.frame_rate
    name = path.name.lower()
    if not (path.exists() or is_live(arguments)):
        raise UsageError(f'there is no file {path}')
    _check_used(arguments)
    if is_topic(arguments):
        source = open_topic(arguments.source, woven=woven)
    elif is_device(path):
        source = open_device(path, arguments.pixel_format, arguments.size, rate)
    elif is_bag(path):
        source = open_bag(path, arguments.topic, calibrated=calibrated, woven=woven)
    elif path.is_dir():
        source = open_folder(path)
    elif arguments.pixel_format:
        source = open_raw(path, arguments.pixel_format, arguments.size, arguments.stride)
    elif name.endswith(video.SUFFIXES):
        source = video.open_video(path)
    elif name.endswith(tiff.SUFFIXES):
        source = tiff.open_tiff(path)
    elif fits.is_fits(path):
        source = fits.open_fits(path)
    else:
        raise SourceError(_unread(path))
    if rate is not None and not is_device(path):
        source = replace(
            source, frames=_evenly(source.frames, rate), stamps=f'--frame-rate {rate:g}'
        )
    if arguments.seconds is not None and is_live(arguments):
        source = replace(source, frames=_for_seconds(source.frames, arguments.seconds))
    count = arguments.count
    if count is not None:
        there = source.count
        source = replace(
            source, frames=islice(source.frames, count),
            count=None if there is None else min(there, count),
        )
    return source


def _check_used(arguments: argparse.Namespace) -> None:
    """Raise UsageError for an option that SOURCE does not use: its frames would be other ones."""
    path = Path(arguments.source)
    camera, bag = is_device(path), is_bag(path)
    named = path.name.lower().endswith((*video.SUFFIXES, *tiff.SUFFIXES, *UNREAD))
    dump = path.is_file() and not (bag or named or fits.is_fits(path))
    for option, given, used, right in (
        ('--topic', arguments.topic, bag, 'a bag'),
        ('--seconds', arguments.seconds, is_live(arguments), 'a camera or a topic'),
        # `calibrate response` writes it into its file, whatever it reads.
        ('--pixel-format', arguments.pixel_format, camera or dump or 'camera' in arguments,
         'a camera or a raw dump'),
        ('--size', arguments.size, camera or dump, 'a camera or a raw dump'),
        ('--stride', arguments.stride, dump, 'a raw dump'),
    ):
        if given and not used:
            raise UsageError(f'{option} is for {right}, and {path} is none: leave it out')


def unstamped(arguments: argparse.Namespace) -> str:
    """Say that the frames of SOURCE have no stamps, and what to do."""
    return f'the frames of {arguments.source} have no stamps: give their rate, --frame-rate 60'


def grey_frames(
    source: Source, *, interpolate: bool = True, response: Response | None = None
) -> Iterator[GreyFrame]:
    """
    Yield the frames of a source without their colours.

    Parameters
    ----------
    source : Source
        Open.
    interpolate : bool
        Whether the frames of a Bayer mosaic are interpolated to all pixels, for their places; else
        they are samples of one colour, for their noise.
    response : Response, optional
        Makes the pixels linear, each colour by itself.

    Yields
    ------
    GreyFrame
        Raw pixels, or linear ones.

    Raises
    ------
    SourceError
        If one cannot be read, or the response is of other ones.

    """
    first_ns: int | None = None
    for name, frame, stamped, told in source.frames:
        first_ns = frame.stamp_ns if first_ns is None else first_ns
        seconds = (frame.stamp_ns - first_ns) / 1e9 if stamped else None
        sensor = told or reach(frame)
        if response is not None:
            frame = linear_frame(frame, sensor, response)
        try:
            pixels = grey_pixels(frame, interpolate=interpolate)
        except ValueError as error:
            raise SourceError(f'{name}: {error}') from None
        yield GreyFrame(name, seconds, pixels, sensor)


def _evenly(frames: Iterable[SourceFrame], rate: float) -> Iterator[SourceFrame]:
    """Yield frames at an even rate, Hz."""
    for index, each in enumerate(frames):
        frame = replace(each.frame, stamp_ns=round(1e9 * index / rate))
        yield each._replace(frame=frame, stamped=True)


def _for_seconds(frames: Iterable[SourceFrame], longest: float) -> Iterator[SourceFrame]:
    """Yield what comes of a live source in so many seconds."""
    began = time.monotonic()
    for each in frames:
        yield each
        if time.monotonic() - began >= longest:
            return


def _unread(path: Path) -> str:
    """Say of a file that nothing here reads what to do with it."""
    suffix = path.suffix.lower()
    if suffix in SUFFIXES:
        return f'{path} is one image; give the folder that holds the images'
    if suffix in UNREAD:
        return f'{path}: {suffix[1:].upper()} is not read; {UNREAD[suffix]}'
    return (
        f'{path} is a file of an unknown kind; give a folder of images, a video, a TIFF, a FITS '
        'or a bag, or say what a raw dump holds: --pixel-format Y12P --size 640x480'
    )


def _size(word: str) -> tuple[int, int]:
    width, _, height = word.lower().partition('x')
    try:
        size = int(width), int(height)
    except ValueError:
        size = 0, 0
    if min(size) < 1:
        raise argparse.ArgumentTypeError(f'{word} is not a size; write 640x480')
    return size


def _positive_int(word: str) -> int:
    try:
        value = int(word)
    except ValueError:
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"'{word}' is not a whole number above 0; write 12 say")
    return value


def _positive_float(word: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = 0.0
    if not 0.0 < value < float('inf'):
        raise argparse.ArgumentTypeError(
            f"'{word}' is not a number above 0; write 60 say, without a unit: --help names it"
        )
    return value
