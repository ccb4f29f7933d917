"""calibrate convert: another program's calibration file in the form of ROS."""

from __future__ import annotations

import argparse
from pathlib import Path

from blob_tracker.camera import (
    CalibrationError, CameraModel, read_calibration, write_calibration,
)
from blob_tracker.commands.calibrate.report import picture_size, tell_of, warn
from blob_tracker.commands.exit_code import check_out
from rich.console import Console

FAILURES = (CalibrationError,)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        'file', type=Path, metavar='FILE',
        help='calibration of OpenCV (YAML, XML, JSON), Kalibr, basalt, OCamCalib, a .ini of ROS, '
        'or an echoed camera_info',
    )
    parser.add_argument('--camera', default='', help='name of the camera in a file of several')
    parser.add_argument(
        '--size', type=picture_size, metavar='WIDTHxHEIGHT',
        help='of the calibrated pictures, if the file does not say',
    )
    parser.add_argument(
        '--out', type=Path, default=Path('camera_info.yaml'),
        help='for the parameter camera_info_url of the camera (%(default)s)',
    )


def main(arguments: argparse.Namespace) -> None:
    """Convert."""
    check_out(arguments.out, '', arguments.file)
    choice = {'camera': arguments.camera, 'size': arguments.size}
    model = CameraModel.from_file(arguments.file, warn=warn, **choice)
    region = read_calibration(arguments.file, **choice).region
    tell_of(Console(), arguments.out)
    write_calibration(arguments.out, model, [f'from {arguments.file.name}'], region)
