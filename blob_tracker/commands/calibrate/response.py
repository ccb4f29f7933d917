"""`calibrate response`: the curve of a camera whose pixels are not proportional to the light."""

from __future__ import annotations

import argparse
from dataclasses import replace
from math import isfinite, isnan
from pathlib import Path
import shlex

from blob_tracker.calibration.response_flats import READ_NOISE_E, response_of_flats
from blob_tracker.calibration.response_measurement import ResponseError, ResponseMeasurement
from blob_tracker.calibration.response_picture import draw_response
from blob_tracker.calibration.response_series import measure_response, Shot
from blob_tracker.camera import CalibrationError
from blob_tracker.commands.calibrate.exposures import shots_of
from blob_tracker.commands.calibrate.frame_index import INDEX
from blob_tracker.commands.calibrate.report import results_table, Row, row, tell_of
from blob_tracker.commands.exit_code import check_out, UsageError
from blob_tracker.commands.sources import add_source
from blob_tracker.types import Pixels
import numpy as np
from rich.console import Console

FAILURES = (CalibrationError, ResponseError)
LINEAR = 0.02  # by which the exponent of a linear camera may seem to be off 1
SHOWN = (0.25, 0.5, 0.75)  # of full scale, at which the error is told


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.description = (
        'The response of a camera with a gamma curve, a knee or a limited range. SOURCE shows one '
        f'still scene at several exposures: a folder with an {INDEX} (file,exposure; exposure 0 '
        'with the cap on), or anything with --exposures. Or, with --flats, pairs of flat frames '
        'at several unknown brightnesses.'
    )
    add_source(parser, 'a still scene at several exposures', response=False)
    parser.add_argument(
        '--exposures', type=_exposures, default=[], metavar='T,T,...',
        help='times in the order of the frames, in any unit: those of a folder sorted by name, as '
        'many of each; else each held for four frames or more',
    )
    parser.add_argument(
        '--flats', action='store_true',
        help='the frames are flat, two of each light, and the light is not known',
    )
    parser.add_argument('--dark', metavar='FOLDER', help='two dark frames, for --flats')
    parser.add_argument(
        '--read-noise', type=float, default=READ_NOISE_E, metavar='E',
        help='of the sensor, electrons, by its data sheet: for --flats (%(default)s)',
    )
    parser.add_argument(
        '--saturation', type=int, metavar='DN', help='level of a clipped pixel, if known'
    )
    parser.add_argument('--camera', default='', help='its name, for the file')
    parser.add_argument(
        '--out', type=Path, default=Path('response.yaml'),
        help='for the parameter response_url of segmenter and locator (%(default)s); the picture '
        'beside',
    )


def main(arguments: argparse.Namespace) -> None:
    """Calibrate."""
    check_out(arguments.out, '.png')
    if arguments.flats and arguments.exposures:
        raise UsageError('--flats are of unknown lights; leave out --exposures')
    if arguments.dark and not arguments.flats:
        raise UsageError('--dark is for --flats; of exposures, 0 is that of dark frames')
    if not (isfinite(arguments.read_noise) and arguments.read_noise >= 0.0):
        raise UsageError(f'--read-noise is {arguments.read_noise}; it must be 0 or more')
    console = Console()
    shots = shots_of(arguments, console, arguments.exposures)
    names = {'camera': arguments.camera, 'pixel_format': arguments.pixel_format}
    if arguments.flats:
        flats, dark = _flats(arguments, console, shots)
        measurement = response_of_flats(
            flats, dark=dark, saturation=arguments.saturation, read_noise=arguments.read_noise,
            sensor=shots[0].sensor, **names,
        )
    elif any(isnan(each.exposure) for each in shots):
        raise UsageError(
            f'the exposures are not known: give --exposures, a folder with an {INDEX} '
            '(file,exposure), or --flats for flat frames of unknown light'
        )
    else:
        with console.status(f'fitting the response to {len(shots)} exposures'):
            measurement = measure_response(shots, saturation=arguments.saturation, **names)
    _report(console, measurement)
    tell_of(console, arguments.out)
    measurement.response.to_yaml(
        arguments.out,
        [
            'python3 -m blob_tracker calibrate response',
            'levels in raw DN, linear and its standard deviation in linear DN, 16 to a raw one',
        ],
    )
    picture = arguments.out.with_suffix('.png')
    tell_of(console, picture)
    draw_response(picture, measurement)
    _say_how_to_use(console, arguments, measurement)


def _flats(
    arguments: argparse.Namespace, console: Console, shots: list[Shot]
) -> tuple[list[tuple[Pixels, Pixels]], tuple[Pixels, Pixels] | None]:
    """Return the pairs of flat frames, and that of dark ones."""
    if arguments.dark:
        dark = argparse.Namespace(**{**vars(arguments), 'source': arguments.dark})
        shots = shots + [
            replace(each, exposure=0.0) for each in shots_of(dark, console, [])
        ]
    pairs = [(each.exposure, each.frames) for each in shots if len(each.frames) == 2]
    dark_pairs = [(frames[0], frames[1]) for time, frames in pairs if time == 0.0]
    bright = [(frames[0], frames[1]) for time, frames in pairs if time != 0.0]
    return bright, dark_pairs[0] if dark_pairs else None


def _report(console: Console, measurement: ResponseMeasurement) -> None:
    """Print the table and what is to be said about it."""
    response, line = measurement.response, measurement.line
    black, black_sigma = measurement.black_level
    raw_black = float(np.interp(black, response.linear, response.levels))
    rows: list[Row] = [
        row('exponent that it is nearest to', measurement.exponent, None, ''),
        row('level of a clipped pixel', float(response.saturation), None, 'raw DN'),
        row('level of no light', raw_black, None, 'raw DN'),
    ]
    slope = np.gradient(response.linear, response.levels)
    for part in SHOWN:
        level = part * response.saturation
        sigma = float(np.interp(level, response.levels, response.sigma))
        at_level = float(np.interp(level, response.levels, slope))
        rows.append(row(
            f'its error at {level:.0f} DN', sigma / max(at_level, 1e-3), None, 'raw DN'
        ))
    if measurement.residuals.any():
        off = float(np.sqrt((measurement.residuals**2).mean()))
        rows.append(row('points off the curve, rms', off, None, 'raw DN'))
    noise = measurement.noise
    if line is not None and noise is not None:
        sigma_gain, sigma_read = np.sqrt(np.diag(line.noise_covariance))
        rows += [
            row('noise.gain', noise.gain, float(sigma_gain), 'e-/linear DN'),
            row('noise.read_noise', noise.read_noise, float(sigma_read), 'linear DN'),
        ]
    rows.append(row('noise.black_level', black, black_sigma, 'linear DN'))
    console.print(results_table(f'response, {response.method}', rows))
    for warning in measurement.warnings:
        console.print(f'- {warning}', highlight=False)
    if abs(measurement.exponent - 1.0) < LINEAR:
        console.print('- the camera is linear: leave response_url empty')


def _say_how_to_use(
    console: Console, arguments: argparse.Namespace, measurement: ResponseMeasurement
) -> None:
    """Print the parameters to copy, and what is still to be measured."""
    words = f'-p response_url:={arguments.out.resolve().as_uri()}'
    noise = measurement.noise
    if noise is None:
        console.print(
            '- the noise of linear pixels is unknown from these frames: python3 -m blob_tracker '
            f'calibrate noise SOURCE --response {shlex.quote(str(arguments.out))}',
            soft_wrap=True, highlight=False,
        )
    else:
        words += (
            f' -p noise.gain:={noise.gain:.6g} -p noise.read_noise:={noise.read_noise:.6g} '
            f'-p noise.black_level:={noise.black_level:.6g}'
        )
    console.print(words, markup=False, soft_wrap=True, highlight=False)


def _exposures(words: str) -> list[float]:
    try:
        times = [float(word) for word in words.split(',')]
    except ValueError:
        raise argparse.ArgumentTypeError(f'{words} must be numbers with commas') from None
    if not all(isfinite(time) and time >= 0.0 for time in times):
        raise argparse.ArgumentTypeError(f'{words}: a time must be 0 or more')
    return times
