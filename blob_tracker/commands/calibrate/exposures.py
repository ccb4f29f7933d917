"""The frames of a source, put together by their exposure or their light."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator, Sequence
from math import nan
from pathlib import Path

from blob_tracker.calibration.response_series import Shot
from blob_tracker.commands.calibrate.frame_index import INDEX, index_rows
from blob_tracker.commands.calibrate.noise_pairs import frames_of, STEP
from blob_tracker.commands.sources import GreyFrame, is_folder, SourceError
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray
from rich.console import Console

MOST_FRAMES = 16  # of one exposure: more tell little that these do not
COLUMNS = ('exposure', 'exposure_ns')


class _Group:
    """Frames of one exposure, of which the mean and the first two are kept."""

    def __init__(self, exposure: float = nan) -> None:
        self.exposure = exposure
        self.frames: list[Pixels] = []
        self.count = 0
        self.sensor = 0, 0
        self._sum: NDArray[np.float64] | None = None

    def add(self, taken: GreyFrame) -> None:
        """Take a frame."""
        frame, self.sensor = taken.pixels, taken.sensor
        if self.count == MOST_FRAMES:
            return
        if self._sum is None:
            self._sum = np.zeros(frame.shape)
        if frame.shape != self._sum.shape:
            raise SourceError(
                f'the frames differ in size: {self._sum.shape[1]} x {self._sum.shape[0]} and '
                f'{frame.shape[1]} x {frame.shape[0]} px'
            )
        if len(self.frames) < 2:
            self.frames.append(frame)
        self._sum += frame
        self.count += 1

    def shot(self, exposure: float | None = None) -> Shot:
        """Return what came."""
        assert self._sum is not None
        mean = np.asarray(self._sum / self.count, dtype=np.float32)
        time = self.exposure if exposure is None else exposure
        return Shot(time, mean, tuple(self.frames), self.sensor)


def shots_of(
    arguments: argparse.Namespace, console: Console, exposures: Sequence[float]
) -> list[Shot]:
    """
    Return the exposures of a source.

    Parameters
    ----------
    arguments : Namespace
        Of a parser that `add_source` filled.
    console : Console
        Shows the progress.
    exposures : sequence of float
        Times, in the order in which they come; empty if nobody knows, and they are nan.

    Raises
    ------
    SourceError
        If there are other numbers of frames than of exposures, or an index is wrong.

    """
    stream = frames_of(arguments, console)
    if not is_folder(arguments):
        return _given(_runs(stream), exposures)
    index = Path(arguments.source) / INDEX
    if index.is_file() and not exposures:
        return _indexed(index, stream)
    frames = list(stream)
    each = len(frames) // len(exposures) if exposures else 2
    if not each or len(frames) % each or (exposures and len(frames) != each * len(exposures)):
        raise SourceError(
            f'{len(frames)} frames do not divide evenly among {len(exposures)} exposures; sort '
            'the names by exposure, with as many frames for each'
            if exposures else f'the number of frames, {len(frames)}, is odd; each light needs two'
        )
    groups = []
    for k in range(0, len(frames), each):
        groups.append(_Group())
        for frame in frames[k:k + each]:
            groups[-1].add(frame)
    return _given(groups, exposures)


def _given(groups: Sequence[_Group], exposures: Sequence[float]) -> list[Shot]:
    """Return the groups with their exposures."""
    if not exposures:
        return [each.shot() for each in groups]
    if len(groups) != len(exposures):
        raise SourceError(
            f'the brightness goes in {len(groups)} steps and --exposures has {len(exposures)}; '
            'hold each exposure for four frames or more, each brighter or darker than the one '
            'before it'
        )
    return [each.shot(time) for each, time in zip(groups, exposures)]


def _runs(stream: Iterable[GreyFrame]) -> list[_Group]:
    """
    Return the runs of one brightness.

    The first frame of each may be one in which the exposure changed, and is left out; so is a run
    of one frame.
    """
    groups: list[_Group] = []
    level = -1.0
    for frame in stream:
        mean = float(frame.pixels.mean())
        if level < 0.0 or abs(mean - level) > STEP * level + 1.0:
            if groups and not groups[-1].count:
                groups.pop()
            groups.append(_Group())
            level = mean
            continue
        groups[-1].add(frame)
    if groups and not groups[-1].count:
        groups.pop()
    return groups


def _indexed(index: Path, stream: Iterator[GreyFrame]) -> list[Shot]:
    """Return the exposures of a folder by its index."""
    rows, columns = index_rows(index)
    column = next((name for name in COLUMNS if name in columns), None)
    if 'file' not in columns or column is None:
        raise SourceError(
            f'{index} has the columns {", ".join(columns) or "(none)"}; it must have file and '
            f'{" or ".join(COLUMNS)}, and may have kind (bright or dark)'
        )
    times: dict[str, float] = {}
    for row in rows:
        try:
            times[row['file']] = 0.0 if row.get('kind') == 'dark' else float(row[column])
        except (TypeError, ValueError):
            raise SourceError(
                f"{index}: {column} of {row['file']} is '{row[column]}'; it must be a number"
            ) from None
    groups: dict[float, _Group] = {}
    for frame in stream:
        if frame.name in times:
            time = times.pop(frame.name)
            groups.setdefault(time, _Group(time)).add(frame)
    if times:
        raise SourceError(f'{index} names {min(times)}, which is not in the folder')
    return [each.shot() for each in groups.values()]
