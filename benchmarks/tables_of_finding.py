"""Tables of what is measured on whole frames: what is found, what is false, how fast."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan

from benchmarks.capture import Row as CaptureRow
from benchmarks.detection import ASKED_SNR, OURS, Row as DetectionRow, share, SNRS
from benchmarks.files import Row as FileRow
from benchmarks.finders import FINDERS
from benchmarks.lab import Row as LabRow
from benchmarks.real_frames import Row as FrameRow
from benchmarks.search import Row as SearchRow
from rich.table import Table


def lab(rows: Sequence[LabRow]) -> Table:
    """Return frames a second of the virtual lab."""
    table = Table('scene', 'frames a second', title='The virtual lab on one core')
    for row in rows:
        table.add_row(row.scene, f'{row.per_second:,.0f}')
    return table


def frames(rows: Sequence[FrameRow]) -> Table:
    """Return what the segmenter finds in whole real frames."""
    table = Table(
        'frames',
        'of',
        'found',
        'others not refused',
        'SNR of the strongest of them',
        'windows, of lines those off it',
        'why no window',
        title='Real frames: the laser line of each pair, the stars above peak SNR 8',
        caption='others: off the line, by its colour; not in the catalogue, most of them stars',
    )
    for row in rows:
        table.add_row(
            row.kind,
            row.name,
            f'{row.found} of {row.total}',
            str(row.others),
            f'{row.strongest_other:.0f}',
            str(row.windows),
            row.reason,
        )
    return table


def detection(rows: Sequence[DetectionRow]) -> list[Table]:
    """Return who is compared, the curve, the scenes at the SNR asked for, and what was false."""
    return [_finders(), _curve(rows), _scenes(rows), _false(rows)]


def search(rows: Sequence[SearchRow]) -> Table:
    """Return microseconds and ratio of each path on each kind of frame."""
    kinds = list(dict.fromkeys((row.size, row.depth) for row in rows))
    table = Table(
        'path',
        *(f'{size}, {depth}' for size, depth in kinds),
        title='One frame, us (x cv2.subtract + cv2.minMaxLoc of the same frames)',
        caption='lost: the whole frame is searched; (n %): lit frames that gave a window',
    )
    one_each = {(row.size, row.depth): row for row in rows}
    reference = [f'{one_each[kind].reference * 1e6:,.0f}' for kind in kinds]
    table.add_row('subtract + minMaxLoc', *reference)
    for path in dict.fromkeys(row.path for row in rows):
        found = {(row.size, row.depth): row for row in rows if row.path == path}
        table.add_row(path, *(_search_cell(found[kind]) for kind in kinds))
    return table


def capture(rows: Sequence[CaptureRow]) -> Table:
    """Return microseconds from the driver's buffer to the reader, and of a copy."""
    table = Table(
        'GREY', 'frame at the reader, us', 'one copy, us', 'ratio',
        title='After DQBUF: decoding, stamp, capture thread to the reader',
    )
    for row in rows:
        table.add_row(
            row.size, f'{row.seconds * 1e6:,.0f}', f'{row.reference * 1e6:,.0f}',
            f'{row.ratio:.2f}',
        )
    return table


def files(rows: Sequence[FileRow]) -> Table:
    """Return images a second from each kind of bag, beside the libraries by hand."""
    table = Table(
        'bag', 'images/s', 'rosbags and OpenCV by hand', 'ratio', 'grows by, MB',
        title='Images of 640 x 480 from bags',
    )
    for row in rows:
        table.add_row(
            row.bag, f'{row.rate:,.0f}', f'{row.reference:,.0f}', f'{row.ratio:.2f}',
            f'{row.memory:.1f}',
        )
    return table


def _finders() -> Table:
    """Return the others' ways with their settings."""
    table = Table('beside it', 'setting', title='Other ways to find a spot in a whole frame')
    for each in FINDERS:
        table.add_row(each.name, each.setting)
    return table


def _curve(rows: Sequence[DetectionRow]) -> Table:
    table = Table(
        'contender',
        *(f'{snr:g}' for snr in SNRS),
        title='Lit frames found (answers that are not the target), %, against peak SNR',
        caption='all clutter scenes, sigma 1, 2 and 4 px; the others are told which of two frames '
        'is lit, and give the best answer they have',
    )
    for name in dict.fromkeys(row.contender for row in rows):
        mine = [[row for row in rows if (row.contender, row.snr) == (name, snr)] for snr in SNRS]
        table.add_row(name, *map(_detection_cell, mine))
    return table


def _scenes(rows: Sequence[DetectionRow]) -> Table:
    """Return all contenders on each scene at the SNR asked for."""
    names = list(dict.fromkeys(row.contender for row in rows))
    table = Table(
        'scene',
        *names,
        title=f'Lit frames found (answers that are not the target), %, at peak SNR {ASKED_SNR:g}',
    )
    asked = [row for row in rows if row.snr == ASKED_SNR]
    for scene in dict.fromkeys(row.scene for row in asked):
        cells = ([row for row in asked if (row.scene, row.contender) == (scene, n)] for n in names)
        table.add_row(scene, *map(_detection_cell, cells))
    return table


def _false(rows: Sequence[DetectionRow]) -> Table:
    """Return our false windows on each scene."""
    table = Table(
        'scene', 'without a target', 'with a target', title='False windows of blob_tracker'
    )
    ours = [row for row in rows if row.contender == OURS]
    for scene in dict.fromkeys(row.scene for row in ours):
        parts = [
            [row for row in ours if row.scene == scene and isnan(row.snr) == empty]
            for empty in (True, False)
        ]
        table.add_row(scene, *(
            f'{sum(row.false for row in part):,} in {sum(row.frames for row in part):,} frames'
            for part in parts
        ))
    return table


def _detection_cell(rows: Sequence[DetectionRow]) -> str:
    frames = sum(row.frames for row in rows)
    if not frames:
        return ''
    return f'{100 * share(rows):.2f} ({100 * sum(row.false for row in rows) / frames:.1f})'


def _search_cell(row: SearchRow) -> str:
    windows = '' if isnan(row.windows) else f' ({row.windows:.0%})'
    return f'{row.seconds * 1e6:,.0f} ({row.ratio:.2f}x){windows}'
