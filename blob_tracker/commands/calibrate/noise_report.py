"""What was found of the noise, in tables and in a parameter file."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from math import sqrt
from pathlib import Path
import shlex

from blob_tracker.calibration.noise_line import NoiseLine
from blob_tracker.calibration.photon_transfer import PhotonTransfer
from blob_tracker.commands.sources.response import response_of
from blob_tracker.types import SensorNoise
import numpy as np
from rich.console import Console
from rich.table import Table


def rows_of_noise(
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


def print_photon_transfer(console: Console, found: PhotonTransfer) -> None:
    """Print the table of a photon transfer."""
    line = found.line
    table = Table('', 'value', 'standard deviation', title='Photon transfer (EMVA 1288)')
    slope_sigma = sqrt(line.covariance[0, 0])
    if found.system_gain is None:
        table.add_row('system gain K by EMVA 1288, DN/e-', 'unknown without dark frames', '')
    else:
        standard, sigma = found.system_gain
        table.add_row('system gain K by EMVA 1288, DN/e-', f'{standard:.4g}', f'{sigma:.2g}')
    table.add_row(
        'slope of the weighted line, 1 / noise.gain, DN/e-',
        f'{line.slope:.4g}',
        f'{slope_sigma:.2g}',
    )
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
            table.add_row(name, 'unknown from these frames', '')
        else:
            table.add_row(name, f'{scale * pair[0]:.4g}', f'{scale * pair[1]:.2g}')
    table.add_section()
    black_sigma = 'not separated from read noise'
    if found.black_level:
        black_sigma = f'{found.black_level[1]:.2g}'
    for row in rows_of_noise(line, found.noise, black_sigma):
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


def write_parameters(
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
    response = response_of(arguments)
    url = ''
    if response is not None:
        # The nodes are told in raw DN.
        saturation = int(np.searchsorted(response.table, saturation))
        url = f'    response_url: {Path(arguments.response).resolve().as_uri()}\n'
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
        f'    saturation: {saturation}\n{url}'
        '\n/**/segmenter:\n  ros__parameters:\n'
        f'    saturation: {saturation}\n{url}'
    )
    console.print(f'{out} {words}, the transfer curve is {out.with_suffix(".png")}; use it with')
    console.print(
        f'  ros2 run blob_tracker locator --ros-args --params-file {shlex.quote(str(out))}\n'
        f'  ros2 run blob_tracker segmenter --ros-args --params-file {shlex.quote(str(out))}',
        soft_wrap=True, highlight=False,
    )
