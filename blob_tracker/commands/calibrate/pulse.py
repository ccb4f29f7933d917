"""`calibrate pulse`: the shape that lens, focus and light give the blob, from its own flashes."""

from __future__ import annotations

import argparse
from pathlib import Path

from blob_tracker.calibration.pulse_file import PulseFile
from blob_tracker.calibration.pulse_picture import draw_pulse
from blob_tracker.camera import CalibrationError
from blob_tracker.commands.calibrate.report import results_table, row, tell_of
from blob_tracker.commands.exit_code import check_out, UsageError
from blob_tracker.commands.sources import add_source, SourceError
from blob_tracker.commands.sources.response import clipping_level, response_of
from blob_tracker.commands.sources.shown_frames import shown_frames
from blob_tracker.location import learn_pulse, Learned, locate_batch
from blob_tracker.location.noise import pixel_variance
from blob_tracker.location.pulse_learner import stacked
from blob_tracker.segmentation import FrameError, Segmenter
from blob_tracker.segmentation.flash_modes import flash_by_name, FLASH_MODES
from blob_tracker.types import Frame, LocationError, SensorNoise, Window
import numpy as np
from numpy.typing import NDArray
from rich.console import Console

FAILURES = (CalibrationError, LocationError)
LIVE_FRAMES = 2000  # a thousand flashes
INTERVAL_NS = 16_666_667  # ns from frame to frame, where a folder has no stamps
MOST_WINDOWS = 3000  # beyond it the pulse is known far better than any window is placed
BINS = 10
MODES = tuple(name for name in FLASH_MODES if name != 'coded')
CLEAR = 0.02  # of a window's log-likelihood: a pulse that gains less is as good as a Gaussian


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_source(parser, 'the flashing target in motion')
    parser.add_argument('--flash', choices=MODES, default='alternate', help='mode (%(default)s)')
    parser.add_argument('--gain', type=float, default=40.0, help='noise.gain, e-/DN (%(default)s)')
    parser.add_argument(
        '--read-noise', type=float, default=0.7, help='noise.read_noise, DN (%(default)s)'
    )
    parser.add_argument(
        '--black-level', type=float, default=0.0, help='noise.black_level, DN (%(default)s)'
    )
    parser.add_argument(
        '--saturation', type=int, default=0, help='DN of a clipped pixel; 0 is full scale'
    )
    parser.add_argument(
        '--light', default='', help="note on light and channel for the file: '850 nm, mono'"
    )
    parser.add_argument(
        '--out', type=Path, default=Path('pulse.yaml'),
        help='for the parameter pulse_url of the locator (%(default)s); the picture beside',
    )


def main(arguments: argparse.Namespace) -> None:
    """Calibrate."""
    check_out(arguments.out, '.png')
    try:
        noise = SensorNoise(arguments.gain, arguments.read_noise, arguments.black_level)
    except ValueError as error:
        raise UsageError(str(error)) from None
    console = Console()
    windows, width, height, reason = _windows(arguments, console)
    if not windows:
        raise SourceError(f'no flash was found in {arguments.source}: {reason}')
    stacks = stacked(windows)
    with console.status(f'learning the pulse of {len(windows)} windows'):
        learned = learn_pulse(stacks, noise=noise, saturation=windows[0].saturation)
    _report(console, learned)
    tell_of(console, arguments.out)
    PulseFile(learned, width, height, arguments.light).to_yaml(
        arguments.out,
        [
            f'python3 -m blob_tracker calibrate pulse, {learned.windows} windows',
            'cubic B-spline, rows along y, of the pulse with its pixel; unit peak, px',
        ],
    )
    picture = arguments.out.with_suffix('.png')
    tell_of(console, picture)
    draw_pulse(picture, learned, *_by_phase(stacks, learned, windows[0].saturation))
    if learned.gain >= CLEAR:
        console.print(
            f'-p pulse_url:={arguments.out.resolve().as_uri()}', markup=False, soft_wrap=True
        )


def _windows(
    arguments: argparse.Namespace, console: Console
) -> tuple[list[Window], int, int, str]:
    """Return the windows of the source, the size of the sensor, and why the last gave none."""
    segmenter = Segmenter(flash=flash_by_name(arguments.flash))
    windows: list[Window] = []
    width = height = 0
    reason = 'there are no frames'
    response = response_of(arguments)
    for index, (_, seconds, pixels, sensor) in enumerate(shown_frames(
        arguments, console, 'finding the flashes', live_frames=LIVE_FRAMES
    )):
        width, height = sensor
        full = clipping_level(response, arguments.saturation, pixels)
        stamp_ns = index * INTERVAL_NS if seconds is None else round(1e9 * seconds)
        try:
            window = segmenter.update(Frame(pixels, stamp_ns, full))
        except FrameError as error:
            reason = str(error)
            continue
        if window is None:
            reason = segmenter.reason
        else:
            windows.append(window)
        if len(windows) == MOST_WINDOWS:
            break
    return windows, width, height, reason


def _by_phase(
    stacks: list[tuple[NDArray[np.float64], NDArray[np.float64] | None]], learned: Learned,
    saturation: float | None,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the middles of the phases, what is left at the peaks, and the error of that."""
    phases, residuals = [], []
    for lit, unlit in stacks:
        found = locate_batch(
            lit, unlit, noise=learned.noise, saturation=saturation, pulse=learned.pulse
        )
        for n in np.flatnonzero(found.ok):
            column = min(max(int(np.rint(found.x[n])), 0), lit.shape[2] - 1)
            line = min(max(int(np.rint(found.y[n])), 0), lit.shape[1] - 1)
            scale = found.sigma[n] / learned.pulse.sigma
            value = float(learned.pulse.value(
                (column - found.x[n]) / scale, (line - found.y[n]) / scale
            ))
            mean = found.amplitude[n] * value + found.background[n]
            left = lit[n, line, column] - mean
            deviation = pixel_variance(np.array(mean), learned.noise) ** 0.5
            phases.append(found.x[n] - column)
            residuals.append(left / float(deviation))
    place = np.clip(((np.array(phases) + 0.5) * BINS).astype(int), 0, BINS - 1)
    filled = [k for k in range(BINS) if (place == k).any()]
    middles = (np.array(filled) + 0.5) / BINS - 0.5
    left_there = [np.array(residuals)[place == k] for k in filled]
    return (
        middles, np.array([each.mean() for each in left_there]),
        np.array([1.0 / len(each) ** 0.5 for each in left_there]),
    )


def _report(console: Console, learned: Learned) -> None:
    """Print the table and what is to be said about it."""
    pulse = learned.pulse
    sigma = float(np.sqrt(np.trace(pulse.covariance) / 2.0))
    rows = [
        row('sigma of the nearest Gaussian', pulse.sigma, None, 'px'),
        row('error of a place by that of the pulse', sigma, None, 'px'),
        row('chi-square, median', learned.chi2, None, ''),
        row('gain over a Gaussian, log-likelihood a window', learned.gain, None, ''),
        row('widest phase without a window', learned.gap, None, 'px'),
        row('windows', float(learned.windows), None, ''),
    ]
    console.print(results_table(f'pulse, {learned.windows} windows', rows))
    if learned.gain < CLEAR:
        console.print(
            '- the pulse makes the windows no likelier than a Gaussian does: leave pulse_url empty'
        )
