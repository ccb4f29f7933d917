"""Stations measured live, one after the other, into a CSV file."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path

from blob_tracker.commands.calibrate.stations_file import (
    PIXELS, Quantity, read_stations, SIGMAS, StationsError,
)
import numpy as np
from rich.console import Console


def measure_stations(arguments: argparse.Namespace, quantities: Sequence[Quantity]) -> None:
    """Take stations until the user ends, each written at once."""
    try:
        from blob_tracker.ros.endpoints.live_centroids import LiveCentroids, NoCentroidsError
    except ImportError:
        raise StationsError('--live needs ROS: source its setup file') from None

    console = Console(stderr=True)
    joints = getattr(arguments, 'joints', None) or ()
    path: Path = arguments.measurements
    done = 0
    columns = [*(quantity.column for quantity in quantities), *PIXELS, *SIGMAS]
    begun = path.read_text(encoding='utf-8-sig', errors='replace') if path.is_file() else ''
    if begun:
        header, *others = begun.splitlines()
        if header.strip() != ','.join(columns):
            raise StationsError(
                f'{path} cannot be continued: its first line is not {",".join(columns)}'
            )
        done = len(read_stations(path, quantities).pixels) if others else 0
        console.print(f'going on after the {done} stations of {path}')
    try:
        with (
            LiveCentroids(arguments.topic, joints) as centroids,
            open(path, 'a', encoding='utf-8', newline='') as file,
        ):
            if not begun:
                file.write(','.join(columns) + '\n')
            elif not begun.endswith('\n'):  # an editor's
                file.write('\n')
            for settings in _visits(arguments, quantities, done, measured=bool(joints)):
                while True:
                    try:
                        mean, sigma, angles = centroids.mean(arguments.count)
                        break
                    except NoCentroidsError as error:
                        console.print(f'[red]{error}[/red]')
                        if _ask('Enter tries this station again, q ends: '):
                            return
                if joints:
                    settings = [
                        angle / quantity.units[quantity.unit]
                        for angle, quantity in zip(angles.tolist(), quantities)
                    ]
                # A scatter of exactly nothing is no certainty: the last digit that is written.
                values = [*settings, *mean.tolist(), *np.maximum(sigma, 1e-6).tolist()]
                file.write(','.join(f'{value:.6f}' for value in values) + '\n')
                file.flush()
                console.print(
                    f'x {mean[0]:.4f} ± {sigma[0]:.4f} px, y {mean[1]:.4f} ± {sigma[1]:.4f} px'
                )
    except NoCentroidsError as error:
        raise StationsError(str(error)) from None
    except OSError as error:
        raise StationsError(f'cannot write {path}: {error.strerror}') from None


def _visits(
    arguments: argparse.Namespace,
    quantities: Sequence[Quantity],
    done: int,
    *,
    measured: bool,
) -> Iterator[list[float]]:
    """Ask for one station after the other; yield where each is, in the units of the file."""
    steps = [getattr(arguments, quantity.name) for quantity in quantities]
    if any(each is not None for each in steps) and not measured:
        if any(each is None for each in steps):
            words = ' and '.join(f'--{quantity.name}' for quantity in quantities)
            raise StationsError(f'give {words}, or neither to be asked each time')
        grid = list(product(*steps))
        for index, settings in enumerate(grid[done:], start=done + 1):
            words = ', '.join(
                f'{quantity.name} to {value:g} {quantity.unit}'
                for quantity, value in zip(quantities, settings)
            )
            if _ask(f'station {index} of {len(grid)}: {words}; Enter when it stands, q ends: '):
                return
            yield list(settings)
        return
    names = ' and '.join(f'{quantity.name} ({quantity.unit})' for quantity in quantities)
    while True:
        if measured:
            if _ask(f'station {done + 1}: Enter when it stands, q ends: '):
                return
            done += 1
            yield []
            continue
        answer = _ask(f'station {done + 1}: {names} where it stands, Enter alone ends: ')
        if answer in ('', 'q'):
            return
        try:
            typed = [float(word) for word in answer.replace(',', ' ').split()]
        except ValueError:
            typed = []
        if len(typed) == len(quantities) and np.isfinite(typed).all():
            done += 1
            yield typed
        else:
            print(f'{answer!r} is not {len(quantities)} number(s): {names}')


def _ask(question: str) -> str:
    """Return what was typed; an input that has ended ends the measuring as q does."""
    try:
        return input(question).strip()
    except EOFError:
        return 'q'
