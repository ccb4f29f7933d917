"""The calibrations of `python3 -m blob_tracker calibrate`, one file for each."""

from __future__ import annotations

import argparse
from importlib import import_module
from types import ModuleType

from blob_tracker.commands.exit_code import exit_code
from blob_tracker.commands.sources import SourceError

CALIBRATIONS: dict[str, str] = {
    'board': 'lens, from images of a chessboard, a ChArUco board or a grid of dots',
    'body': 'where the lights are on a body, from turning it before one camera',
    'convert': "another program's calibration file, written as ROS has it",
    'flash': 'which lights blink, how, and the parameters that track them',
    'hand_eye': 'how the camera sits on a pan/tilt, from turning it before a still light',
    'imu': 'how the IMU sits beside the camera, its clock and its bias',
    'jitter': 'line offsets of an analogue grabber, from frames of a vertical edge',
    'line_time': 'how fast a rolling shutter reads its lines, from the bands of a lamp',
    'noise': 'gain, read noise and saturation: photon transfer',
    'pulse': "the blob's shape: lens, focus and light, from its own flashes",
    'response': 'gamma and the like: what the pixels make of light',
    'rig': 'where cameras are, and their clocks, from a light that is waved before them',
    'slide': 'pixels per millimetre, from a camera on a slide',
    'turn': "focal length and principal point, from the servo's own steps",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the calibrations and the options of each."""
    kinds = parser.add_subparsers(dest='calibration', metavar='WHAT', required=True)
    for name, summary in CALIBRATIONS.items():
        _module(name).add_arguments(kinds.add_parser(name, help=summary, description=summary))


def main(arguments: argparse.Namespace) -> int:
    """
    Calibrate.

    Parameters
    ----------
    arguments : Namespace
        Of the parser that `add_arguments` filled.

    Returns
    -------
    int
        Exit code: 0 done, 1 failed, 2 called wrongly, 130 after Ctrl-C.

    """
    module = _module(arguments.calibration)
    return exit_code(lambda: module.main(arguments), (SourceError, *module.FAILURES))


def _module(name: str) -> ModuleType:
    return import_module(f'blob_tracker.commands.calibrate.{name}')
