"""`calibrate noise`: photon transfer, from flat frames or from an ordinary scene."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator, Sequence
import csv
from math import inf, sqrt
from pathlib import Path
import shlex
import signal
import sys

from blob_tracker.calibration.noise_level_function import NoiseLevelFunction
from blob_tracker.calibration.noise_line import NoiseLine
from blob_tracker.calibration.photon_transfer import (
    clipped_level,
    Pair,
    pair_of,
    photon_transfer,
    PhotonTransfer,
    PhotonTransferError,
)
from blob_tracker.calibration.photon_transfer_picture import draw_noise_line
from blob_tracker.commands.calibrate.report import refusal
from blob_tracker.commands.calibrate.sources import (
    add_source, frames, is_folder, is_live, SourceError,
)
from blob_tracker.types import Pixels, SensorNoise
import numpy as np
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

INDEX = 'index.csv'
KINDS = ('bright', 'dark')
SAME = 0.05  # of the mean, and 5 DN, by which the two frames of a pair may differ in light
STEP = 0.02  # of the mean, and 1 DN, beyond which a stream of frames shows another step
LIVE_SECONDS = 60.0  # of a topic, where neither --seconds nor --count is given
MOST_PAIRS = 8  # of one step: more tell little that eight do not


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.description = (
        'Photon transfer (EMVA 1288): gain, read noise, saturation and non-uniformity from pairs '
        f'of frames. SOURCE is a folder with an {INDEX} (file,kind,exposure_ns,photons_per_pixel; '
        'kind is bright or dark); or a folder of bright frames, sorted in pairs, with --dark; or '
        'a bag or topic in which the light goes up in steps, dark first, each held for three '
        'frames or more; or, with --scene, anything recorded with a camera that stands still.'
    )
    add_source(parser, 'an even light at several brightnesses, or of a still scene')
    parser.add_argument('--dark', metavar='FOLDER', help='dark frames, sorted in pairs')
    parser.add_argument(
        '--scene', action='store_true',
        help='the frames show a still scene: no even light is needed, PRNU and DSNU are not told',
    )
    parser.add_argument(
        '--saturation', type=int, metavar='DN', help='level of a clipped pixel, where it is known'
    )
    parser.add_argument(
        '--out', type=Path, default=Path('noise.yaml'), metavar='FILE',
        help='parameter file to write (%(default)s); the picture goes beside it, as .png',
    )


def main(arguments: argparse.Namespace) -> int:
    """
    Measure the noise of a camera.

    Parameters
    ----------
    arguments : Namespace
        Of the parser that `add_arguments` filled.

    Returns
    -------
    int
        Exit code: 0 done, 1 failed, 2 called wrongly.

    Raises
    ------
    KeyboardInterrupt
        On Ctrl-C: the second one of a topic, of which the first ends the listening.

    """
    if arguments.scene and arguments.dark:
        print('--scene needs no dark frames; leave out --dark', file=sys.stderr)
        return 2
    if not arguments.out.parent.is_dir():
        print(f'{arguments.out.parent} is not a folder; make it first', file=sys.stderr)
        return 2
    wrong = refusal(arguments.out, '.png')
    if wrong:
        print(wrong, file=sys.stderr)
        return 2
    try:
        if arguments.scene:
            _scene(arguments)
        else:
            _photon_transfer(arguments)
    except (SourceError, PhotonTransferError) as error:
        print(error, file=sys.stderr)
        return 1
    except OSError as error:
        print(f'{error.filename}: {error.strerror}', file=sys.stderr)
        return 1
    return 0


def _photon_transfer(arguments: argparse.Namespace) -> None:
    """Measure with flat frames, print, draw and write."""
    console = Console()
    pairs = _pairs(arguments, console)
    found = photon_transfer(pairs, arguments.saturation)
    _print(console, found)
    mean = np.array([each.mean for each in found.pairs])
    draw_noise_line(
        arguments.out.with_suffix('.png'),
        found.line,
        mean - (found.black_level[0] if found.black_level else 0.0),
        np.array([each.variance for each in found.pairs]),
        np.array([each.scatter for each in found.pairs]),
        found.used,
        title=f'Photon transfer of {len(found.pairs)} pairs',
        label='mean level above black, DN',
    )
    _write(console, arguments, found.line, found.noise, found.saturation, found.warnings)


def _scene(arguments: argparse.Namespace) -> None:
    """Measure with the frames of a still scene, print, draw and write."""
    console = Console()
    measured = NoiseLevelFunction(memory=inf, tiles=None)
    pairs = tiles = full = 0
    seen = deep = False
    brightest: Pair | None = None
    for first, second in _in_twos(_shown(arguments, console), odd=True):
        pair = pair_of(first, second)
        if brightest is None or (
            (pair.highest, pair.at_highest) > (brightest.highest, brightest.at_highest)
        ):
            brightest = pair
            full, seen = clipped_level([brightest], arguments.saturation)
        deep = first.dtype == np.uint16
        pairs += 1
        try:
            tiles += measured.add(first, second, full, pairs)
        except ValueError as error:
            raise PhotonTransferError(str(error)) from None
    if not pairs:
        raise PhotonTransferError(f'{arguments.source} has fewer than two frames')
    line = measured.line()
    if line is None:
        raise PhotonTransferError(measured.reason)
    table = Table('', 'value', 'standard deviation', title='Noise level function')
    for row in _rows_of_noise(line, line.noise, 'not told apart from read noise'):
        table.add_row(*row)
    table.add_row('pairs of frames, tiles used', f'{pairs}, {tiles}', '')
    console.print(table)
    draw_noise_line(
        arguments.out.with_suffix('.png'), line, *measured.points(),
        title=f'Noise of a scene, {tiles} tiles of {pairs} pairs', label='level, DN',
    )
    warnings = []
    if not (seen or arguments.saturation):
        full = 0 if deep else full
        warnings.append(
            'no pixel is clipped: saturation 0, full scale of 16 bits, is written; give '
            '--saturation where the camera has fewer, 4095 for 12'
            if deep else
            f'no pixel is clipped; the saturation of {full} DN is what the values suggest'
        )
    if not line.fits:
        warnings.append(
            f'the points lie off the line by more than their noise (chi2 {line.chi2:.0f} for '
            f'{line.dof}); the sigmas have grown by it'
        )
    _write(console, arguments, line, line.noise, full, warnings)


def _pairs(arguments: argparse.Namespace, console: Console) -> list[Pair]:
    """Return the pairs of any of the sources."""
    folder = Path(arguments.source)
    if arguments.dark:
        dark = argparse.Namespace(**{**vars(arguments), 'source': arguments.dark})
        return [
            *(
                _pair(two, dark=each is dark)
                for each in (dark, arguments)
                # A topic ends anywhere.
                for two in _in_twos(_shown(each, console), odd=is_live(each))
            ),
        ]
    if not is_folder(arguments):
        pairs = _steps(image for _, image in _shown(arguments, console))
        console.print(f'{len(pairs)} pairs; the darkest step is taken for the dark one')
        return pairs
    if not (folder / INDEX).is_file():
        raise SourceError(
            f'{folder} has no {INDEX}; write one (file,kind,exposure_ns,photons_per_pixel), give '
            'the dark frames of these bright ones with --dark FOLDER, or say --scene if they '
            'show a still scene'
        )
    return _indexed(arguments, folder / INDEX, console)


def _shown(arguments: argparse.Namespace, console: Console) -> Iterator[tuple[str, Pixels]]:
    """Yield the frames of a source, of a topic up to Ctrl-C at most, with a progress bar."""
    stream = frames(arguments)
    if is_live(arguments):
        if arguments.seconds is None and arguments.count is None:
            arguments.seconds = LIVE_SECONDS
        limits = [f'{arguments.seconds:g} s'] if arguments.seconds else []
        limits += [f'{arguments.count} frames'] if arguments.count else []
        console.print(
            f'Listening to {arguments.source} for {" or ".join(limits)}; Ctrl-C ends it earlier, '
            'and what came by then is measured.', highlight=False,
        )
        stream = _until_interrupt(stream)
    with Progress(console=console, transient=True) as progress:
        task = progress.add_task(f'frames of {arguments.source}', total=None)
        for name, image in stream:
            progress.update(task, advance=1)
            yield name, image


def _until_interrupt(stream: Iterator[tuple[str, Pixels]]) -> Iterator[tuple[str, Pixels]]:
    """
    Yield what a stream has until Ctrl-C; a second one is Python's again.

    While a frame is waited for, it ends the waiting; work on one that came is finished first.
    """
    ended = waiting = False
    before = signal.getsignal(signal.SIGINT)

    def end(*_: object) -> None:
        nonlocal ended
        ended = True
        signal.signal(signal.SIGINT, before)
        if waiting:
            raise KeyboardInterrupt

    signal.signal(signal.SIGINT, end)
    try:
        while not ended:
            try:
                waiting = True
                each = next(stream)
                waiting = False
            except (KeyboardInterrupt, StopIteration):
                return
            yield each
    finally:
        signal.signal(signal.SIGINT, before)


def _in_twos(
    stream: Iterable[tuple[str, Pixels]], *, odd: bool = False
) -> Iterator[tuple[Pixels, Pixels]]:
    """Yield the frames two by two; one that is left over is an error where `odd` is not set."""
    count, held = 0, None
    for _, image in stream:
        count += 1
        if held is None:
            held = image
        else:
            yield held, image
            held = None
    if held is not None and not odd:
        raise PhotonTransferError(
            f'{count} frames are no whole number of pairs; each light needs two frames'
        )


def _pair(two: tuple[Pixels, Pixels], *, dark: bool, exposure: float | None = None) -> Pair:
    """Return the statistics of a pair, or say that its frames do not belong together."""
    means = [float(each.mean()) for each in two]
    if abs(means[0] - means[1]) > SAME * min(means) + 5.0:
        raise PhotonTransferError(
            f'two frames that should be a pair have means of {means[0]:.0f} and {means[1]:.0f} DN;'
            ' sort the names so that the two frames of each light come one after the other'
        )
    return pair_of(*two, dark=dark, exposure=exposure)


def _steps(stream: Iterable[Pixels]) -> list[Pair]:
    """
    Return the pairs of a stream in which the light goes up or down in steps.

    A step is a run of frames of one mean; its first frame may be one in which the light changed,
    and is left out where there are three or more. The darkest step is dark.
    """
    runs: list[list[Pair]] = []
    run: list[Pair] = []
    held: Pixels | None = None
    mean, length = -inf, 0
    for image in stream:
        level = float(image.mean())
        if abs(level - mean) > STEP * mean + 1.0 or mean < 0.0:
            mean, length, held, run = level, 0, None, []
            runs.append(run)
        length += 1
        if length == 1 or len(run) == MOST_PAIRS:
            continue
        if held is None:
            held = image
        else:
            run.append(_pair((held, image), dark=False))
            held = None
    pairs = [pair for run in runs for pair in run]
    if not pairs:
        raise PhotonTransferError(
            'no step of the light lasts for three frames; hold each brightness longer'
        )
    darkest = min(each.mean for each in pairs)
    return [
        Pair(**{**vars(each), 'dark': each.mean <= darkest * (1.0 + STEP) + 1.0})
        for each in pairs
    ]


def _indexed(arguments: argparse.Namespace, index: Path, console: Console) -> list[Pair]:
    """Return the pairs of a folder by its index."""
    try:
        # Spreadsheets begin UTF-8 with a byte order mark.
        with index.open(newline='', encoding='utf-8-sig') as file:
            reader = csv.DictReader(file)
            rows = list(reader)
            columns = reader.fieldnames or []
    except (UnicodeDecodeError, csv.Error) as error:
        raise PhotonTransferError(
            f'{index} cannot be read: {error}; save it as CSV in UTF-8'
        ) from None
    if not {'file', 'kind'} <= set(columns):
        raise PhotonTransferError(
            f'{index} has the columns {", ".join(columns) or "(none)"}; it must have file and '
            'kind, and may have exposure_ns and photons_per_pixel'
        )
    for row in rows:
        if row['kind'] not in KINDS:
            raise PhotonTransferError(
                f"{index}: the kind of {row['file']} is '{row['kind']}'; it must be bright or dark"
            )
    bright = [row for row in rows if row['kind'] == 'bright']
    # Of time and photons the one that tells the levels apart.
    varied = [
        name for name in ('exposure_ns', 'photons_per_pixel')
        if name in columns and len({row[name] for row in bright}) > 1
    ]
    groups: dict[tuple[str, str, str], list[Pixels]] = {}
    where = {
        row['file']: (
            row['kind'], row.get('exposure_ns') or '', row.get('photons_per_pixel') or ''
        )
        for row in rows
    }
    pairs, seen = [], set()
    for name, image in _shown(arguments, console):
        if name not in where:
            continue
        seen.add(name)
        key = where[name]
        group = groups.setdefault(key, [])
        group.append(image)
        if len(group) == 2:
            column = (varied or [''])[0]
            value = {'exposure_ns': key[1], 'photons_per_pixel': key[2]}.get(column, '')
            try:
                exposure = float(value) if value else None
            except ValueError:
                raise PhotonTransferError(
                    f"{index}: {column} of {name} is '{value}'; it must be a number"
                ) from None
            pairs.append(
                _pair((group[0], group[1]), dark=key[0] == 'dark', exposure=exposure)
            )
            group.clear()
    missing = sorted(set(where) - seen)
    if missing:
        raise PhotonTransferError(f'{index} names {missing[0]}, which is not in the folder')
    for (kind, exposure_ns, photons), left in groups.items():
        if left:
            light = exposure_ns and f' at {exposure_ns} ns' or photons and f' at {photons} photons'
            raise PhotonTransferError(
                f'{index}: the number of {kind} frames{light} is odd; each light needs two frames'
            )
    return pairs


def _rows_of_noise(
    line: NoiseLine, noise: SensorNoise, black_sigma: str
) -> Iterator[tuple[str, str, str]]:
    """Yield what the locator takes, in words."""
    sigma = np.sqrt(np.diag(line.noise_covariance))
    product = float(sigma[0] * sigma[1])
    together = float(line.noise_covariance[0, 1]) / product if product > 0.0 else 0.0
    yield 'noise.gain, e-/DN', f'{noise.gain:.4g}', f'{sigma[0]:.2g}'
    yield 'noise.read_noise, DN', f'{noise.read_noise:.4g}', f'{sigma[1]:.2g}'
    yield 'correlation of the two', f'{together:+.2f}', ''
    yield 'noise.black_level, DN', f'{noise.black_level:.4g}', black_sigma


def _print(console: Console, found: PhotonTransfer) -> None:
    """Print the table of a photon transfer."""
    line = found.line
    table = Table('', 'value', 'standard deviation', title='Photon transfer (EMVA 1288)')
    slope_sigma = sqrt(line.covariance[0, 0])
    table.add_row('system gain K, DN/e-', f'{line.slope:.4f}', f'{slope_sigma:.2g}')
    table.add_row(
        'temporal dark noise, e-',
        f'{line.read_noise * line.gain:.2f}',
        f'{_electrons_sigma(line):.2g}',
    )
    measured = [
        ('saturation level, DN (peak of the curve)', found.saturation_level, 1.0),
        ('saturation capacity, e-', found.capacity, 1.0),
        ('DSNU, e-', found.dsnu, 1.0),
        ('PRNU, %', found.prnu, 100.0),
        ('linearity error, %', found.linearity_error, 100.0),
    ]
    for name, pair, scale in measured:
        if pair is None:
            table.add_row(name, 'not told by these frames', '')
        else:
            table.add_row(name, f'{scale * pair[0]:.4g}', f'{scale * pair[1]:.2g}')
    table.add_section()
    black_sigma = 'not told apart from read noise'
    if found.black_level:
        black_sigma = f'{found.black_level[1]:.2g}'
    for row in _rows_of_noise(line, found.noise, black_sigma):
        table.add_row(*row)
    table.add_row('saturation, DN', str(found.saturation), '')
    console.print(table)
    console.print(
        f'{int(found.used.sum())} of {len(found.pairs)} pairs fitted; chi2 {line.chi2:.1f} for '
        f'{line.dof} degrees of freedom'
    )


def _electrons_sigma(line: NoiseLine) -> float:
    """Return the standard deviation of read noise times gain, electrons."""
    row = np.array([line.read_noise, line.gain])
    return sqrt(float(row @ line.noise_covariance @ row))


def _write(
    console: Console,
    arguments: argparse.Namespace,
    line: NoiseLine,
    noise: SensorNoise,
    saturation: int,
    warnings: Sequence[str],
) -> None:
    """Write the parameter file, and say what was written and how to use it."""
    for warning in warnings:
        console.print(f'[yellow]Note:[/yellow] {warning}', highlight=False)
    out: Path = arguments.out
    sigma = np.sqrt(np.diag(line.noise_covariance))
    words = 'overwritten' if out.exists() else 'written'
    out.write_text(
        f'# Noise of a camera, by `python3 -m blob_tracker calibrate noise '
        f'{shlex.quote(arguments.source)}`.\n'
        f'# Standard deviations: gain {sigma[0]:.2g} e-/DN, read noise {sigma[1]:.2g} DN; '
        f'covariance {line.noise_covariance[0, 1]:.2g} e-.\n'
        + ''.join(f'# Note: {warning}\n' for warning in warnings)
        + '\n/**/locator:\n  ros__parameters:\n'
        f'    noise.gain: {noise.gain:.6f}\n'
        f'    noise.read_noise: {noise.read_noise:.6f}\n'
        f'    noise.black_level: {noise.black_level:.6f}\n'
        f'    saturation: {saturation}\n'
        '\n/**/segmenter:\n  ros__parameters:\n'
        f'    saturation: {saturation}\n'
    )
    console.print(f'{out} {words}, the transfer curve is {out.with_suffix(".png")}; use it with')
    console.print(
        f'  ros2 run blob_tracker locator --ros-args --params-file {shlex.quote(str(out))}\n'
        f'  ros2 run blob_tracker segmenter --ros-args --params-file {shlex.quote(str(out))}',
        soft_wrap=True, highlight=False,
    )
