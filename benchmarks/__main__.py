"""python -m benchmarks [accuracy|speed|real] [--quick] [--out DIR]."""

from __future__ import annotations

import argparse
from dataclasses import asdict
import json
import os
from pathlib import Path
import sys

# One core for everybody; libraries read these when they load.
for _variable in ('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS', 'MKL_NUM_THREADS'):
    os.environ.setdefault(_variable, '1')

from benchmarks import accuracy, machine, ours, peers, plots, real_pixels  # noqa: E402, I100
from benchmarks import speed, tables, targets  # noqa: E402, I100
import cv2  # noqa: E402, I201
from rich.console import Console  # noqa: E402
from rich.progress import Progress  # noqa: E402

PARTS = ('accuracy', 'speed', 'real')
FULL = {'count': 10_000, 'phase_count': 400, 'speed_count': 10_000, 'repeats': 7}
QUICK = {'count': 1_500, 'phase_count': 100, 'speed_count': 2_000, 'repeats': 3}
WIDTH = 150  # columns where the output is no terminal


def main(arguments: list[str] | None = None) -> int:
    """Run the parts that are asked for; 0 where every target they decide is met, else 1."""
    asked = _parse(arguments)
    cv2.setNumThreads(1)
    sizes = QUICK if asked.quick else FULL
    parts = asked.part or PARTS
    console = Console(width=None if sys.stdout.isatty() else WIDTH)
    data = real_pixels.data_folder()
    if 'real' in parts and data is None:
        console.print(f'[bold red]{real_pixels.VARIABLE} is not set: no real pixels')
        parts = [part for part in parts if part != 'real']

    own = ours.contenders()
    others, missing = peers.available()
    contenders = own + others
    names = [each.name for each in own] + [ours.LIT_ONLY, ours.DIFFERENCE]
    console.print(tables.settings(contenders, missing))

    rows: list[accuracy.Row] = []
    biases: list[accuracy.Bias] = []
    paces: list[speed.Pace] = []
    real: list[real_pixels.Row] = []
    found: list[targets.Target] = []
    steps = accuracy.steps() * ('accuracy' in parts) + 3 * ('speed' in parts)
    with Progress(console=console, transient=True) as progress:
        task = progress.add_task('', total=steps + 2 * ('real' in parts))

        def tick(what: str) -> None:
            progress.update(task, description=what, advance=1)

        if 'accuracy' in parts:
            rows = accuracy.run(contenders, sizes['count'], tick)
            biases = accuracy.run_bias(contenders, sizes['phase_count'], tick)
            found += targets.accuracy_targets(rows, biases, names)
        if 'speed' in parts:
            paces = speed.run(contenders, sizes['speed_count'], sizes['repeats'], tick)
            found += targets.speed_targets(paces)
        if 'real' in parts and data is not None:
            real = real_pixels.run(contenders, data, tick)

    shown = [*tables.accuracy(rows), tables.bias(biases)] if rows else []
    shown += [tables.speed(paces)] if paces else []
    shown += [tables.real(real)] if real else []
    shown += [tables.targets(found)] if found else []
    for table in shown:
        console.print(table)
    asked.out.mkdir(parents=True, exist_ok=True)
    plots.draw(asked.out, rows, biases, real, names)
    report = {
        'machine': machine.describe(),
        'quick': asked.quick,
        'settings': {each.name: each.setting for each in contenders},
        'missing': missing,
        'accuracy': [asdict(row) for row in rows],
        'bias': [asdict(bias) for bias in biases],
        'speed': [asdict(pace) for pace in paces],
        'real': [asdict(row) for row in real],
        'targets': [{**asdict(each), 'met': each.met} for each in found],
    }
    (asked.out / 'benchmarks.json').write_text(json.dumps(report, indent=1))
    console.print(f'figures and plots: {asked.out}')
    if missing:
        console.print(f'[bold red]not compared with {", ".join(missing)}: not importable')
    return 0 if all(each.met for each in found) else 1


def _parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='python -m benchmarks', description=__doc__)
    parser.add_argument('part', nargs='*', choices=[*PARTS, []], help='which parts; all if none')
    parser.add_argument('--quick', action='store_true', help='fewer windows: a minute, not ten')
    parser.add_argument('--out', type=Path, default=Path('out/benchmarks'), help='folder written')
    return parser.parse_args(arguments)


if __name__ == '__main__':
    sys.exit(main())
