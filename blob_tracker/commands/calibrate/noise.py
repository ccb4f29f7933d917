"""`calibrate noise`: photon transfer, from flat frames or from an ordinary scene."""

from __future__ import annotations

import argparse
from math import inf
from pathlib import Path

from blob_tracker.calibration.frame_pair import Pair, pair_of, PhotonTransferError
from blob_tracker.calibration.noise_level_function import NoiseLevelFunction
from blob_tracker.calibration.photon_transfer import clipped_level, photon_transfer
from blob_tracker.calibration.photon_transfer_picture import draw_noise_line
from blob_tracker.calibration.temporal_correlation import Succession
from blob_tracker.commands.calibrate.frame_index import INDEX
from blob_tracker.commands.calibrate.noise_pairs import frames_of, in_twos, pairs_of, watched
from blob_tracker.commands.calibrate.noise_report import (
    print_photon_transfer, rows_of_noise, write_parameters,
)
from blob_tracker.commands.exit_code import check_out, UsageError
from blob_tracker.commands.sources import add_source
from blob_tracker.commands.sources.response import response_of
import numpy as np
from rich.console import Console
from rich.table import Table

FAILURES = (PhotonTransferError,)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.description = (
        'Photon transfer (EMVA 1288): gain, read noise, saturation and non-uniformity from pairs '
        f'of frames. SOURCE is a folder with an {INDEX} (file,kind,exposure_ns,photons_per_pixel; '
        'kind is bright or dark) or a descriptor of EMVA 1288; or a folder of bright frames, '
        'sorted in pairs, with --dark; or a bag or topic in which the light goes up in steps, '
        'dark first, each held for three frames or more; or, with --scene, anything recorded with '
        'a camera that stands still.'
    )
    add_source(parser, 'an even light at several brightnesses, or of a still scene')
    parser.add_argument('--dark', metavar='FOLDER', help='dark frames, sorted in pairs')
    parser.add_argument(
        '--scene', action='store_true',
        help='the frames show a still scene: no even light is needed, and PRNU and DSNU are not '
        'measured',
    )
    parser.add_argument(
        '--saturation', type=int, metavar='DN', help='level of a clipped pixel, if known'
    )
    parser.add_argument(
        '--out', type=Path, default=Path('noise.yaml'), metavar='FILE',
        help='parameter file to write (%(default)s); the picture goes beside it, as .png',
    )


def main(arguments: argparse.Namespace) -> None:
    """Measure the noise of a camera."""
    if arguments.scene and arguments.dark:
        raise UsageError('--scene needs no dark frames; leave out --dark')
    check_out(arguments.out, '.png')
    response = response_of(arguments)
    if response is not None:
        arguments.saturation = response.linear_saturation(
            arguments.saturation or response.saturation
        )
    if arguments.scene:
        _scene(arguments)
    else:
        _photon_transfer(arguments)


def _photon_transfer(arguments: argparse.Namespace) -> None:
    """Measure with flat frames, print, draw and write."""
    console = Console()
    succession = Succession()
    pairs = pairs_of(arguments, console, succession)
    untested = _check_time(succession)
    found = photon_transfer(pairs, arguments.saturation)
    print_photon_transfer(console, found)
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
    write_parameters(
        console, arguments, found.line, found.noise, found.saturation,
        [*found.warnings, *untested],
    )


def _check_time(succession: Succession) -> list[str]:
    """Refuse frames that hang together in time; return a warning where that cannot be told."""
    found = succession.found()
    if found is None:
        return [
            'no three frames of one light follow each other: whether the camera takes out noise '
            'over time (temporal noise reduction), which would falsify all of this, is unknown. '
            'Take three or more in a row of each light'
        ]
    if found.fault:
        raise PhotonTransferError(found.fault)
    return []


def _scene(arguments: argparse.Namespace) -> None:
    """Measure with the frames of a still scene, print, draw and write."""
    console = Console()
    measured = NoiseLevelFunction(memory=inf, tiles=None)
    pairs = tiles = full = 0
    seen = deep = False
    brightest: Pair | None = None
    succession = Succession()
    for first, second in in_twos(
        watched(frames_of(arguments, console), succession), odd=True
    ):
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
    warnings = _check_time(succession)
    line = measured.line()
    if line is None:
        raise PhotonTransferError(measured.reason)
    table = Table('', 'value', 'standard deviation', title='Noise level function')
    for row in rows_of_noise(line, line.noise, 'not separated from read noise'):
        table.add_row(*row)
    table.add_row('pairs of frames, tiles used', f'{pairs}, {tiles}', '')
    console.print(table)
    draw_noise_line(
        arguments.out.with_suffix('.png'), line, *measured.points(),
        title=f'Noise of a scene, {tiles} tiles of {pairs} pairs', label='level, DN',
    )
    if not (seen or arguments.saturation):
        full = 0 if deep else full
        warnings.append(
            'no pixel is clipped: saturation 0, full scale of 16 bits, is written; give '
            '--saturation if the camera has fewer, 4095 for 12'
            if deep else
            f'no pixel is clipped; the saturation of {full} DN is what the values suggest'
        )
    if not line.fits:
        warnings.append(
            f'the points lie off the line by more than their noise (chi2 {line.chi2:.0f} for '
            f'{line.dof}); the sigmas have grown by it'
        )
    write_parameters(console, arguments, line, line.noise, full, warnings)
