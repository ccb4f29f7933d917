"""calibrate turn: focal length and principal point from the servo's own steps."""

from __future__ import annotations

import argparse
from pathlib import Path

from blob_tracker.calibration.turn import calibrate_turn, TurnCalibration
from blob_tracker.calibration.turn_picture import draw_turn
from blob_tracker.calibration.turn_start import TurnError
from blob_tracker.camera import (
    CalibrationError, CameraModel, read_calibration, write_calibration,
)
from blob_tracker.camera.lens import LENSES
from blob_tracker.commands.calibrate.report import (
    picture_size, results_table, row, tell_of, warn, WORTHLESS,
)
from blob_tracker.commands.calibrate.stations import add_stations, stations
from blob_tracker.commands.calibrate.stations_file import PAN, Stations, StationsError, TILT
from blob_tracker.commands.exit_code import check_out, UsageError
from blob_tracker.units import MRAD_PER_RAD
from rich.console import Console

FAILURES = (CalibrationError, StationsError, TurnError)
QUANTITIES = (PAN, TILT)
FIELD_OF_VIEW = 60.0  # degrees: the start of a fit that nothing else is known of
UNITS = {'k1': ('', 1.0), 'fx': ('px', 1.0), 'fy': ('px', 1.0), 'cx': ('px', 1.0)}
UNITS['cy'] = UNITS['cx']


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_stations(parser, QUANTITIES)
    parser.add_argument(
        '--joints',
        type=_names,
        metavar='PAN,TILT',
        help='with --live: take the angles from these joints of joint_states',
    )
    parser.add_argument(
        '--camera-info',
        type=Path,
        metavar='FILE',
        help='first guess: its size, lens model and distortion are kept',
    )
    parser.add_argument(
        '--size', type=picture_size, metavar='WIDTHxHEIGHT',
        help='of the picture, if there is no first guess',
    )
    parser.add_argument(
        '--fit-distortion', action='store_true', help='fit k1, the first distortion coefficient'
    )
    parser.add_argument('--one-f', action='store_true', help='square pixels: fy is fx')
    parser.add_argument(
        '--fix-centre', action='store_true', help='keep the principal point of the first guess'
    )
    parser.add_argument(
        '--step-sigma',
        type=float,
        default=0.0,
        metavar='MRAD',
        help='standard deviation of an angle of the servo',
    )
    parser.add_argument(
        '--range', type=float, metavar='MM', help='of the target from the axes; else it is far'
    )
    parser.add_argument(
        '--offset',
        type=float,
        default=0.0,
        metavar='MM',
        help='of the lens in front of the crossing of the axes',
    )
    parser.add_argument(
        '--out',
        type=Path,
        default=Path('camera_info.yaml'),
        help='where the calibration goes (%(default)s); the picture of the residuals beside it',
    )


def main(arguments: argparse.Namespace) -> None:
    """Calibrate."""
    if (arguments.camera_info is None) == (arguments.size is None):
        raise UsageError('give --camera-info FILE or --size 640x480, one of them')
    if arguments.offset and not arguments.range:
        raise UsageError('--offset counts with --range only: give the range of the target')
    if arguments.range is not None and not arguments.range > abs(arguments.offset):
        raise UsageError('--range must be above 0 and beyond the lens')
    check_out(arguments.out, '', arguments.measurements, arguments.camera_info)
    if arguments.camera_info is not None:
        guess = CameraModel.from_file(arguments.camera_info, warn=warn)
        if arguments.fit_distortion and 'k1' not in LENSES[guess.distortion_model].names:
            raise UsageError(f'--fit-distortion: {guess.distortion_model} has no k1; leave it out')
    else:
        width, height = arguments.size
        guess = CameraModel.from_field_of_view(width, height, FIELD_OF_VIEW)
    measured = stations(arguments, QUANTITIES)
    result = calibrate_turn(
        measured.settings[:, 0],
        measured.settings[:, 1],
        measured.pixels,
        guess,
        pixel_sigma=measured.sigma,
        step_sigma=arguments.step_sigma / MRAD_PER_RAD,
        one_focal_length=arguments.one_f,
        fit_centre=not arguments.fix_centre,
        fit_distortion=arguments.fit_distortion,
        offset=arguments.offset / arguments.range if arguments.range else 0.0,
    )
    console = Console()
    _report(console, result, measured, arguments)
    relative = max(result.sigmas[name] / result.values[name] for name in ('fx', 'fy'))
    if relative > WORTHLESS:
        raise TurnError(
            f'the focal length is known to {100.0 * relative:.0f} % only: nothing is written'
        )
    tell_of(console, arguments.out)
    write_calibration(arguments.out, result.model, _comments(result))
    picture = arguments.out.with_name(f'{arguments.out.stem}_residuals.png')
    tell_of(console, picture)
    draw_turn(picture, measured.pixels, result)


def _report(
    console: Console, result: TurnCalibration, measured: Stations, arguments: argparse.Namespace
) -> None:
    """Print the table and what is to be said about it."""
    rows = []
    for name, value in result.values.items():
        unit, size = UNITS.get(name, ('mrad', MRAD_PER_RAD))
        title = f'target {name}' if name in ('azimuth', 'elevation') else name
        title = f'camera {name}' if name in ('yaw', 'pitch', 'roll') else title
        rows.append(row(title, value * size, result.sigmas[name] * size, unit))
    rms = float((result.residuals**2).mean() ** 0.5)
    rows.append(row('residuals, rms', rms, None, 'px'))
    if measured.sigma is not None or arguments.step_sigma:
        rows.append(('chi2 per degree', f'{result.chi2 / result.freedom:.2f}', '', ''))
    console.print(results_table(f'camera on its servo, {len(measured.pixels)} stations', rows))
    for note in result.notes:
        console.print(f'- {note}', markup=False)
    if arguments.camera_info is not None:
        guess = read_calibration(arguments.camera_info).arguments['matrix']
        ratio = result.values['fx'] / guess[0, 0]
        if not 1.0 / 3.0 < ratio < 3.0:  # no lens is known so badly; degrees are 17 mrad
            console.print(
                f'- fx is {ratio:.2g} times that of {arguments.camera_info}: is the unit of the '
                'angles right?'
            )
    if result.factor > 1.0 and (measured.sigma is not None or arguments.step_sigma):
        console.print(
            f'- the residuals are {result.factor ** 0.5:.1f} times what the sigmas say; those of '
            'the table are grown by as much (is the distortion right? see the picture)'
        )
    if not arguments.range:
        console.print(
            '- the target is taken as far: a lens in front of the axes makes the focal length too '
            'long by offset over range, 1 % for 50 mm at 5 m; --range and --offset take it off'
        )


def _comments(result: TurnCalibration) -> list[str]:
    """Return what the file tells of its making."""
    sigmas = ', '.join(
        f'{name} {result.sigmas[name]:.3g}'
        for name in UNITS
        if result.sigmas[name] > 0.0
    )
    return [
        f'python3 -m blob_tracker calibrate turn, {len(result.residuals)} stations',
        f'standard deviations (px, k1 without unit): {sigmas}',
        *result.notes,
    ]


def _names(words: str) -> tuple[str, ...]:
    names = tuple(words.split(','))
    if len(names) != len(QUANTITIES) or not all(names):
        raise argparse.ArgumentTypeError(f"'{words}' must be two names, PAN,TILT")
    return names
