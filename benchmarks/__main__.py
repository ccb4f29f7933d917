"""
Measure segmentation and location beside other people's, on the same frames and windows.

The part `latency` runs the nodes themselves, beside bare hops of rclpy.

Prints tables, writes figures as JSON and plots as PNG, and ends with the targets: the exit code
is 0 where all that this run decides are met, 1 where one is missed.
"""

from __future__ import annotations

import argparse
from dataclasses import asdict
import json
from math import isnan
import os
from pathlib import Path
import sys
from typing import Any

# One core for everybody; libraries read these when they load.
for _variable in ('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS', 'MKL_NUM_THREADS'):
    os.environ.setdefault(_variable, '1')

from benchmarks import (  # noqa: E402
    machine, ours, peers, plots, real_pixels, tables, targets, world,
)
from benchmarks.contender import SLOWEST  # noqa: E402
from benchmarks.report import FULL, measure, PARTS, QUICK, steps  # noqa: E402
from benchmarks.world import baseline  # noqa: E402
import cv2  # noqa: E402
from rich.console import Console  # noqa: E402
from rich.progress import Progress  # noqa: E402

WIDTH = 180  # columns where the output is no terminal


def main(arguments: list[str] | None = None) -> int:
    """Run the parts that are asked for, all where none is named."""
    asked = _parse(arguments)
    cv2.setNumThreads(1)
    console = Console(width=None if sys.stdout.isatty() else WIDTH)
    parts = asked.parts or list(PARTS)
    data = real_pixels.data_folder()
    if 'real' in parts and data is None:
        console.print(f'[bold red]no real pixels: {real_pixels.VARIABLE} is not set')
        parts.remove('real')

    own = ours.contenders()
    others, missing = peers.available()
    contenders = own + others
    if asked.quick:
        slow = [each.name for each in contenders if each.share < SLOWEST]
        contenders = [each for each in contenders if each.name not in slow]
        console.print(f'left out of --quick: {", ".join(slow) or "none"}')
    console.print(tables.settings(contenders, missing))
    sizes = QUICK if asked.quick else FULL
    with Progress(console=console, transient=True) as progress:
        task = progress.add_task('', total=steps(parts, sizes, asked.beside))
        report = measure(
            parts,
            contenders,
            sizes,
            data,
            lambda what: progress.update(task, description=what, advance=1),
            asked.seed,
            asked.beside,
            asked.load,
        )

    names = [each.name for each in own + ours.texture_references()] + [
        real_pixels.CORRECTED, real_pixels.LEARNED,
    ]
    judged = targets.judge(report, names)
    for table in tables.figures(report, names):
        console.print(table)
    if judged:
        console.print(tables.targets(judged))
    asked.out.mkdir(parents=True, exist_ok=True)
    plots.draw(asked.out, report, names)
    if report.world:
        baseline.write(asked.out / 'world.csv', report.world, machine.commit())
    record = {
        'machine': machine.describe(),
        'quick': asked.quick,
        'seed': asked.seed,
        'settings': {each.name: each.setting for each in contenders},
        'missing': missing,
        **asdict(report),
        'targets': [{**asdict(each), 'met': each.met} for each in judged],
    }
    (asked.out / 'benchmarks.json').write_text(json.dumps(_plain(record), indent=1))
    console.print(f'figures and plots: {asked.out}')
    if missing:
        console.print(f'[bold red]not compared with {", ".join(missing)}: not importable')
    return 0 if all(each.met for each in judged) else 1


def _plain(value: Any) -> Any:
    """Return the value with None for NaN, which JSON does not know."""
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    if isinstance(value, list):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and isnan(value) else value


def _parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='python -m benchmarks', description=__doc__)
    parser.add_argument('parts', nargs='*', metavar='|'.join(PARTS), help='all if none is named')
    parser.add_argument('--quick', action='store_true', help='less of each: three minutes in all')
    parser.add_argument('--out', type=Path, default=Path('out/benchmarks'), help='folder written')
    parser.add_argument(
        '--seed', type=int, default=world.SEED, help='of the situations in the part world'
    )
    parser.add_argument(
        '--beside', type=Path, metavar='FOLDER', help='the part latency alone: the nodes of this '
        'source tree and of that one in turns, and the ratios; the work tree of a commit, say'
    )
    parser.add_argument(
        '--load', action='store_true', help='with --beside: another process keeps a core busy'
    )
    asked = parser.parse_args(arguments)
    if asked.load and asked.beside is None:
        parser.error('--load is for --beside alone')
    if asked.beside is not None:
        if asked.parts != ['latency']:
            parser.error('--beside is for the part latency alone')
        if not (asked.beside / 'benchmarks' / 'latency').is_dir():
            parser.error(f'{asked.beside} has no benchmarks/latency: it is no source tree')
    unknown = set(asked.parts) - set(PARTS)
    if unknown:
        parser.error(f'no part {", ".join(sorted(unknown))}; there is {", ".join(PARTS)}')
    return asked


if __name__ == '__main__':
    sys.exit(main())
