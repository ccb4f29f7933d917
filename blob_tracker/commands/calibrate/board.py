"""Lens from images of a chessboard, a ChArUco board or a grid of dots."""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import replace
from datetime import datetime, timezone
from pathlib import Path
import shlex
import sys

from blob_tracker.calibration.board import BoardCalibration, calibrate_board, LEAST_VIEWS
from blob_tracker.calibration.board_advice import advice
from blob_tracker.calibration.board_picture import draw_board_calibration, SUFFIXES
from blob_tracker.calibration.board_views import BoardViews
from blob_tracker.calibration.boards import (
    Board, BoardError, CharucoBoard, Chessboard, DotGrid, View,
)
from blob_tracker.calibration.boards.regularity import is_even
from blob_tracker.camera import CalibrationError, LensError, write_calibration
from blob_tracker.camera.lens import LENSES
from blob_tracker.commands.calibrate.report import WORTHLESS
from blob_tracker.commands.exit_code import UsageError
from blob_tracker.commands.sources import (
    add_source, grey_frames, is_folder, is_live, open_source, SourceError,
)
from blob_tracker.commands.sources.response import response_of
from blob_tracker.types import Pixels
import cv2
import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

FAILURES = (CalibrationError,)
KINDS = ('charuco', 'chessboard', 'dots')
LIVE_VIEWS = 30  # that differ: more add little
PARTS = {  # of width and height
    'centre': (0.5, 0.5),
    'top left corner': (0.0, 0.0),
    'top right corner': (1.0, 0.0),
    'bottom left corner': (0.0, 1.0),
    'bottom right corner': (1.0, 1.0),
}
TELLING_VIEWS = 4  # from which on the progress tells what is missing
DOUBTFUL_PX = 0.5  # rms; a flat board, a fixed lens and sharp pictures have 0.02 to 0.3
WRONG_PX = 2.0  # rms beyond which the camera found is none
HANGS_TOGETHER = 4.0  # growth of the covariance that is told of: twice the sigmas
MISCOUNTED = 'are --columns and --rows its own (of a chessboard the inner corners)?'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `python3 -m blob_tracker calibrate board`."""
    add_source(parser, 'a board in many poses')
    parser.add_argument('--kind', choices=KINDS, required=True, help='what is on the board')
    parser.add_argument(
        '--columns', type=int, required=True,
        help='of a chessboard the inner corners, of ChArUco the squares, of dots the dots',
    )
    parser.add_argument('--rows', type=int, required=True, help='the same, in the other direction')
    parser.add_argument(
        '--square', type=float, required=True,
        help='side of a square, or distance of two rows of dots, mm',
    )
    parser.add_argument('--marker', type=float, help='side of a ChArUco marker, mm')
    parser.add_argument(
        '--dictionary', default='DICT_4X4_50', help='of the ChArUco markers (%(default)s)'
    )
    parser.add_argument(
        '--asymmetric', action='store_true', help='every other row of dots is shifted'
    )
    parser.add_argument(
        '--model', choices=sorted(name for name, lens in LENSES.items() if lens.names),
        default='plumb_bob',
        help='equidistant for a fish-eye (%(default)s)',
    )
    parser.add_argument(
        '--views', type=int, default=LIVE_VIEWS,
        help='of a topic: end with so many that differ (%(default)s)',
    )
    parser.add_argument(
        '--out', type=Path, default=Path('camera_info.yaml'), help='calibration (%(default)s)'
    )
    parser.add_argument(
        '--picture', type=Path, default=Path('out/calibration_board.png'),
        help='of coverage and residuals (%(default)s)',
    )
    parser.add_argument('--name', default='camera', help='of the camera (%(default)s)')


def main(arguments: argparse.Namespace) -> None:
    """
    Calibrate a camera.

    Raises
    ------
    KeyboardInterrupt
        On Ctrl-C: the second one of a topic, of which the first ends the listening.

    """
    try:
        board = _board(arguments)
    except BoardError as error:
        raise UsageError(str(error)) from None
    if arguments.views < LEAST_VIEWS:
        raise UsageError(f'--views is {arguments.views}; it must be {LEAST_VIEWS} or more')
    if arguments.picture.suffix.lower() not in SUFFIXES:
        raise UsageError(
            f'--picture is {arguments.picture}; it must end in one of {", ".join(SUFFIXES)}'
        )
    views = _of_one_size(_views(arguments, board))
    console = Console()
    with console.status('fitting the camera'):
        found = calibrate_board(views, arguments.model, arguments.name)
    _report(console, found)
    if found.rms > WRONG_PX:
        raise CalibrationError(
            f'the points lie {found.rms:.1f} px from where any camera would see them: nothing is '
            f"written; {MISCOUNTED} Is the board stiff, and --model the lens's kind?"
        )
    relative = float((found.sigmas[:2] / found.values[:2]).max())
    if relative > WORTHLESS:
        raise CalibrationError(
            f'the focal length is known to {100.0 * relative:.0f} % only: nothing is written; is '
            f'the board tilted, and {MISCOUNTED}'
        )
    _write(console, arguments, found, board)


def _board(arguments: argparse.Namespace) -> Board:
    """Return the board that the options speak of."""
    columns, rows, square = arguments.columns, arguments.rows, arguments.square
    if arguments.asymmetric and arguments.kind != 'dots':
        raise BoardError(f'--asymmetric is for dots; the board is a {arguments.kind}')
    if arguments.kind == 'chessboard':
        return Chessboard(columns, rows, square)
    if arguments.kind == 'dots':
        return DotGrid(columns, rows, square, arguments.asymmetric)
    if arguments.marker is None:
        raise BoardError('a ChArUco board needs --marker, the side of its markers in mm')
    return CharucoBoard(columns, rows, square, arguments.marker, arguments.dictionary)


def _views(arguments: argparse.Namespace, board: Board) -> list[View]:
    """Return the views of the board in a folder: all; of a stream: those that differ."""
    every: list[View] = []
    even, uneven = 0, list[str]()
    choice = None if is_folder(arguments) else BoardViews(board)
    seen: tuple[str, Pixels] | None = None
    without: list[str] = []
    with Progress(
        TextColumn('{task.description}'), BarColumn(), TaskProgressColumn(), TimeElapsedColumn(),
        TextColumn('{task.fields[hint]}'),
        console=Console(stderr=True),
    ) as progress:
        live = is_live(arguments)
        source = open_source(arguments)
        total = arguments.views if live else source.count
        task = progress.add_task('looking for the board', total=total, hint='')
        if live:
            progress.console.print(
                f'Move the {board.description} about: tilted all ways, near and far, into all '
                'corners; Ctrl-C ends it.', highlight=False,
            )
        try:
            for count, (name, _, image, _) in enumerate(
                grey_frames(source, response=response_of(arguments)), start=1
            ):
                seen = name, image
                view = board.find(image, name)
                if view is None:
                    without.append(name)
                elif not is_even(view):
                    uneven.append(name)
                    view = None
                else:
                    even += 1
                if choice is None:
                    every += [] if view is None else [view]
                elif choice.offer(view):
                    every = choice.views
                    progress.update(task, hint=_hint(every, arguments.model))
                progress.update(
                    task,
                    completed=len(every) if live else count,
                    description=f'{len(every)} views in {count} images',
                )
                if live and len(every) >= arguments.views:
                    break
        except KeyboardInterrupt:
            if not live:
                raise
        except SourceError as error:
            if not (live and len(every) >= LEAST_VIEWS):
                raise
            print(f'{error}; calibrating with what came before', file=sys.stderr)
    if len(uneven) > even:
        raise CalibrationError(
            f'the points found in {len(uneven)} images, {uneven[0]} for one, do not lie like '
            f'those of a {board.description}: {MISCOUNTED}'
        )
    if not every:
        raise SourceError(_not_found(arguments, board, seen))
    if without and choice is None:
        print(
            f'no {board.description} in {len(without)} of {count} images: ' + ', '.join(without),
            file=sys.stderr,
        )
    if uneven:
        names = ', '.join(uneven)
        print(f'left out, as the points found are not an even grid: {names}', file=sys.stderr)
    return every


def _of_one_size(views: list[View]) -> list[View]:
    """Return the views of the size that most have, and name the others."""
    (size, _), = Counter(view.size for view in views).most_common(1)
    others = [view for view in views if view.size != size]
    if others:
        print(
            f'left out, as their size is not {size[0]} x {size[1]} px: ' + ', '.join(
                f'{view.name} ({view.size[0]} x {view.size[1]})' for view in others
            ),
            file=sys.stderr,
        )
    return [view for view in views if view.size == size]


def _hint(views: list[View], model: str) -> str:
    """Return what is missing so far, for whoever holds the board."""
    if len(views) < TELLING_VIEWS:
        return ''
    try:
        missing = advice(calibrate_board(views, model))
    except CalibrationError:
        return 'tilt the board'
    return missing[-1].split(': ')[-1] if missing else 'nothing is missing: Ctrl-C ends it'


def _not_found(
    arguments: argparse.Namespace, board: Board, seen: tuple[str, Pixels] | None
) -> str:
    """Say what was sought, and where to see what there was instead."""
    if seen is None:
        return f'no image came from {arguments.source}'
    name, image = seen
    if is_folder(arguments):
        place = Path(arguments.source) / name
    else:
        place = arguments.picture.with_name('no_board.png')
        place.parent.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(place), image)
    other = _other_count(board, image)
    if other is not None:
        return (
            f'no {board.description} in any image; {place} for one has a {other.description}: '
            f'give --columns {other.columns} --rows {other.rows} (one less than the squares)'
        )
    return (
        f'no {board.description} in any image, {place} for one: is the whole board in sight, '
        'sharp, with a bright margin, and are --kind, --columns and --rows its own?'
    )


def _other_count(board: Board, image: Pixels) -> Chessboard | None:
    """Return the chessboard that is there where one was counted wrong by one, by squares say."""
    if not isinstance(board, Chessboard):
        return None
    for more in (-1, 1):
        for across, down in ((more, more), (more, 0), (0, more)):
            try:
                other = replace(board, columns=board.columns + across, rows=board.rows + down)
            except BoardError:
                continue
            view = other.find(image)
            if view is not None and is_even(view):
                return other
    return None


def _report(console: Console, found: BoardCalibration) -> None:
    """Print parameters, bearings, views, and what the views leave open."""
    table = Table(title=f'{found.model.name}, {found.model.distortion_model}')
    for heading in ('parameter', 'value', 'sigma'):
        table.add_column(heading, justify='left' if heading == 'parameter' else 'right')
    for name, value, sigma in zip(found.names, found.values, found.sigmas):
        unit = ' (px)' if name in ('fx', 'fy', 'cx', 'cy') else ''
        table.add_row(name + unit, *_digits(float(value), float(sigma)))
    console.print(table)
    table = Table(title='what the calibration adds to a bearing (sigma, mrad)')
    for heading in ('place', 'azimuth', 'elevation'):
        table.add_column(heading, justify='left' if heading == 'place' else 'right')
    for place, sigmas in _bearing_sigmas(found).items():
        cells = ['not known'] * 2 if sigmas is None else [f'{each:.3f}' for each in sigmas]
        table.add_row(place, *cells)
    console.print(table)
    for part, known in _part_sigmas(found).items():
        if isinstance(known, LensError):
            console.print(f'[yellow]not known:[/yellow] {part}: {known}', highlight=False)
    table = Table(title='views')
    for heading in ('image', 'points', 'rms (px)'):
        table.add_column(heading, justify='left' if heading == 'image' else 'right')
    for view, rms in zip(found.views, found.view_rms):
        table.add_row(view.name, str(len(view.points)), f'{rms:.4f}')
    console.print(table)
    console.print(
        f'{found.rms:.4f} px rms reprojection error of {sum(len(v.points) for v in found.views)} '
        f'points; one coordinate of a point has a sigma of {found.sigma:.4f} px',
        highlight=False,
    )
    if found.rms > DOUBTFUL_PX:
        console.print(
            f'[yellow]doubtful:[/yellow] {found.rms:.2f} px is much: a board that is bent, a lens '
            'that focuses by itself, blurred pictures, or a lens that needs another --model',
            highlight=False,
        )
    if found.growth > HANGS_TOGETHER:
        console.print(
            f'[yellow]doubtful:[/yellow] the errors of the points of one image hang together, and '
            f'the sigmas are {np.sqrt(found.growth):.1f} times what independent points would '
            'give: a board that is bent, a lens that focuses by itself, or blurred pictures',
            highlight=False,
        )
    for view, rms in found.left_out:
        console.print(
            f'[yellow]left out:[/yellow] {view.name}, whose rms of {rms:.3f} px is beyond three '
            'times the median', highlight=False,
        )
    for sentence in advice(found):
        console.print(f'[yellow]missing:[/yellow] {sentence}', highlight=False)


def _bearing_sigmas(found: BoardCalibration) -> dict[str, tuple[float, float] | None]:
    """Return the sigma of azimuth and elevation at the centre and the worst corner, mrad."""
    known = {
        part: sigmas for part, sigmas in _part_sigmas(found).items()
        if not isinstance(sigmas, LensError)
    }
    centre = known.pop('centre', None)
    all_corners = len(known) == len(PARTS) - 1
    worst = max(known.values(), key=lambda each: float(np.hypot(*each))) if all_corners else None
    return {'centre': centre, 'worst corner': worst}


def _part_sigmas(found: BoardCalibration) -> dict[str, tuple[float, float] | LensError]:
    """Return the sigma of azimuth and elevation in each part, mrad, or why there is none."""
    parts: dict[str, tuple[float, float] | LensError] = {}
    for part, (across, down) in PARTS.items():
        x, y = across * (found.model.width - 1.0), down * (found.model.height - 1.0)
        try:
            azimuth, elevation = np.sqrt(np.diag(found.bearing_covariance(x, y)))
            parts[part] = float(azimuth), float(elevation)
        except LensError as error:
            parts[part] = error
    return parts


def _digits(value: float, sigma: float) -> tuple[str, str]:
    """Return a value and its sigma with two digits of the sigma."""
    places = int(np.clip(1 - np.floor(np.log10(max(sigma, 1e-12))), 1, 9))
    return f'{value:.{places}f}', f'{sigma:.{places}f}'


def _write(
    console: Console, arguments: argparse.Namespace, found: BoardCalibration, board: Board
) -> None:
    """Write calibration and picture, and say which files are new and which were replaced."""
    comments = [
        f'{datetime.now(timezone.utc):%Y-%m-%d %H:%M} UTC: python3 -m blob_tracker calibrate '
        f'board {shlex.quote(arguments.source)}',
        f'{board.description}, {len(found.views)} views, {found.rms:.4f} px rms',
        'standard deviations: ' + ', '.join(
            f'{name} {sigma:.2g}' for name, sigma in zip(found.names, found.sigmas)
        ),
    ]
    comments += [
        f'sigma of a bearing at the {place}, mrad: azimuth {sigmas[0]:.2g}, '
        f'elevation {sigmas[1]:.2g}'
        for place, sigmas in _bearing_sigmas(found).items() if sigmas is not None
    ]
    for path, name in ((arguments.out, 'calibration'), (arguments.picture, 'picture')):
        verb = 'replaced' if path.exists() else 'written'
        if name == 'calibration':
            write_calibration(path, found.model, comments)
        else:
            draw_board_calibration(path, found)
        console.print(f'{name} {verb}: {path}', highlight=False, soft_wrap=True)
