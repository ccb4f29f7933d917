"""Track a light in recorded frames, or those of a camera: a table, a picture, and a video."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
import shlex
import sys
from typing import Any

from blob_tracker import location, segmentation
from blob_tracker.camera import CalibrationError, CameraModel
from blob_tracker.commands import INSTALL_ROS
from blob_tracker.commands.exit_code import check_out, exit_code, INTERRUPTED, UsageError
from blob_tracker.commands.sources import (
    add_source, is_live, is_topic, open_source, reach, Source, SourceError, SourceFrame,
    unstamped,
)
from blob_tracker.commands.sources.shown_frames import in_words, until_interrupt, with_bar
from blob_tracker.commands.track.annotated import Video
from blob_tracker.commands.track.chain import Chain
from blob_tracker.commands.track.options import add_options, values_of
from blob_tracker.commands.track.outcome import Summary
from blob_tracker.commands.track.picture import draw_track
from blob_tracker.commands.track.table import Table
from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.parameters.url import to_path
import numpy as np
from rich.console import Console

MOST_WARNINGS, MOST_REASONS = 5, 3  # that are said


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `python3 -m blob_tracker track`."""
    add_source(parser, 'a light', topics=False, response=False)
    parser.add_argument(
        '--to', choices=('csv', 'bag'), default='csv',
        help='a table, or a bag with target/bearing, target/centroid and target/ray (%(default)s)',
    )
    parser.add_argument(
        '--out', type=Path, metavar='FILE',
        help='what to write (track.csv, or the folder track for a bag); the picture goes beside '
        'it, as .png',
    )
    parser.add_argument(
        '--annotate', action='store_true',
        help='write a video of what was seen as well, beside it as .mp4',
    )
    add_options(parser)


def main(arguments: argparse.Namespace) -> int:
    """
    Track.

    Parameters
    ----------
    arguments : Namespace
        Of the parser that `add_arguments` filled.

    Returns
    -------
    int
        Exit code: 0 done, 1 where no light was placed or the source failed, 2 called wrongly, 130
        after Ctrl-C; what was done until then is kept.

    """
    return exit_code(
        lambda: _track(arguments), (SourceError, CalibrationError), (UsageError, ParameterError)
    )


def _track(arguments: argparse.Namespace) -> int:
    console = Console()
    if is_topic(arguments):
        raise UsageError(
            f'there is no file {arguments.source}; a topic is tracked by the nodes: ros2 run '
            'blob_tracker pipeline --ros-args -p source:=images'
        )
    out = _out(arguments)
    values, notes = values_of(arguments)
    model = _camera_model(values)
    source = open_source(arguments, calibrated=model is None and not values['field_of_view'])
    if not source.stamps:
        raise UsageError(unstamped(arguments))
    with console.status('loading the fits'):
        location.compile_ahead([values['method']])
        segmentation.compile_ahead()
    frames, first = _peeked(source)
    size = reach(first.frame)
    if model is None and values['field_of_view']:
        model = CameraModel.from_field_of_view(*size, values['field_of_view'])
    chain = Chain(values, source.camera_model if model is None else model, first.frame)
    for note in [*notes, *_notes(arguments, source, chain)]:
        console.print(f'- {note}', markup=False, highlight=False, soft_wrap=True)
    summary, stopped, fault = Summary(chain.angles), list[bool](), ''
    with ExitStack() as writers:
        table = _table(arguments, out)
        writers.callback(table.close)
        video = Video(out.with_suffix('.mp4')) if arguments.annotate else None
        if video is not None:
            writers.callback(video.close)
        stream = until_interrupt(frames, lambda: stopped.append(True))
        try:
            for name, frame, _, _ in with_bar(stream, source, arguments, console, 'tracking'):
                outcomes = list(chain.outcomes(name, frame))
                summary.frames.append(frame.stamp_ns)
                for outcome in outcomes:
                    table.add(outcome)
                    summary.add(outcome)
                if video is not None:
                    video.add(outcomes)
        except (SourceError, CalibrationError) as error:
            fault = str(error)
    _report(console, summary, chain)
    _tell(console, arguments, out, summary, size)
    if fault:
        print(f'{fault}; what came before is kept', file=sys.stderr)
    elif not summary.placed:
        print(_why_none(arguments, summary), file=sys.stderr)
    elif stopped and not is_live(arguments):
        print(f'ended after {len(summary.frames)} frames; they are kept', file=sys.stderr)
        return INTERRUPTED
    return 1 if fault or not summary.placed else 0


def _out(arguments: argparse.Namespace) -> Path:
    """Return where results go; refuse what would be lost by it."""
    out: Path = arguments.out or Path('track.csv' if arguments.to == 'csv' else 'track')
    source = Path(arguments.source)
    check_out(out, '.png', source)
    check_out(out, '.mp4' if arguments.annotate else '', source)
    if arguments.annotate:
        check_out(out.with_suffix('.mp4'), '', source)
    if arguments.to == 'bag' and out.exists():
        raise UsageError(f'--out {out} is there already; name a bag that is not')
    return out


def _table(arguments: argparse.Namespace, out: Path) -> Any:
    """Return what takes the outcomes."""
    if arguments.to == 'csv':
        return Table(out)
    try:
        from blob_tracker.commands.track.bag import Bag
    except ImportError:
        raise UsageError(
            f'--to bag writes messages of ROS, which are not installed: {INSTALL_ROS}; or leave '
            'it out, for a table'
        ) from None
    return Bag(out)


def _camera_model(values: dict[str, Any]) -> CameraModel | None:
    """Return the calibration that was given; None if none was."""
    url = values['camera_info_url']
    return CameraModel.from_file(to_path(url)) if url else None


def _peeked(source: Source) -> tuple[Iterator[SourceFrame], SourceFrame]:
    """Return the frames of a source, and the first of them."""
    frames = iter(source.frames)
    first = next(frames, None)
    if first is None:
        raise SourceError('the source has no frame')

    def again() -> Iterator[SourceFrame]:
        yield first
        yield from frames

    return again(), first


def _notes(arguments: argparse.Namespace, source: Source, chain: Chain) -> Iterator[str]:
    """Yield what there is to be said before anything is tracked."""
    yield f'stamps: by {source.stamps}'
    if not chain.angles:
        why = f'; {source.uncalibrated}' if source.uncalibrated else ''
        yield f'positions in px alone, no angles: give the calibration with --camera-info{why}'
    if chain.note:
        yield f'pulse_url: {chain.note}; the Gaussian is fitted'
    if is_live(arguments):
        longest = in_words(arguments)
        yield f'{f"for {longest}; " if longest else ""}Ctrl-C ends it, and what came is kept'


def _report(console: Console, summary: Summary, chain: Chain) -> None:
    """Print what was found."""
    for light, trail in summary.trails.items():
        spread = np.sqrt(np.diagonal(trail.covariances, axis1=1, axis2=2))
        count = len(trail.stamps)
        words = (
            f'{light or "light"}: {count} position{"s" * (count != 1)} in {len(summary.frames)} '
            f'frames, median sigma {np.median(spread):.2g} {"mrad" if summary.angles else "px"}'
        )
        found = trail.scatter()
        if found is not None:
            words += f', scatter / sigma {found.ratio:.2f} +- {found.error:.2f}'
        console.print(words, markup=False, highlight=False, soft_wrap=True)
    if chain.finding:
        console.print(f'found: {chain.finding}', markup=False, highlight=False, soft_wrap=True)
    for warning, count in chain.warnings.most()[:MOST_WARNINGS]:
        console.print(
            f'- {warning} ({_often(count)})', markup=False, highlight=False,
            soft_wrap=True,
        )


def _tell(
    console: Console, arguments: argparse.Namespace, out: Path, summary: Summary,
    size: tuple[int, int],
) -> None:
    """Draw the picture, and name what was written."""
    written = [out]
    if summary.placed:
        written.append(out.with_suffix('.png'))
        draw_track(written[-1], summary, size)
    if arguments.annotate:
        written.append(out.with_suffix('.mp4'))
    for path in written:
        console.print(str(path), markup=False, highlight=False, soft_wrap=True)


def _often(count: int) -> str:
    return 'once' if count == 1 else f'{count} times'


def _why_none(arguments: argparse.Namespace, summary: Summary) -> str:
    """Say why no light was placed, and what to try."""
    most = ''.join(
        f'\n- {reason} ({_often(count)})'
        for reason, count in summary.reasons.most()[:MOST_REASONS]
    )
    return (
        f'no light was placed in {len(summary.frames)} frames. Is flash.mode right? python3 -m '
        f'blob_tracker calibrate flash {shlex.quote(arguments.source)} says how the lights blink '
        f'{most}'
    )
