"""`calibrate flash`: which lights blink, how, and what to set to track them."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
import shlex
import sys

from blob_tracker.blinking.survey import Light
from blob_tracker.blinking.tracker import MOST_POINTS
from blob_tracker.blinking.wording import describe
from blob_tracker.calibration.flash import (
    enough, flash_settings, FlashSettings, notes,
)
from blob_tracker.calibration.flash_picture import draw_flash
from blob_tracker.commands.calibrate.report import tell_of
from blob_tracker.commands.exit_code import check_out, UsageError
from blob_tracker.commands.sources import add_source, SourceError, unstamped
from blob_tracker.commands.sources.response import clipping_level, response_of
from blob_tracker.commands.sources.shown_frames import shown_frames
from blob_tracker.segmentation import compile_ahead, FrameError, Segmenter
from blob_tracker.segmentation.watch import Watch
from blob_tracker.types import Frame, Pixels
import numpy as np
from rich.console import Console

FAILURES: tuple[type[Exception], ...] = ()
FOLLOWERS = ('locator', 'tracker')  # nodes with the parameter lights
LIVE_S = 10.0
LONGEST_GAP_S = 1.0  # between two frames of one recording
STILL_PX = 1.5  # standard deviation of the places of a light that stands still


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_source(parser, 'lights that blink, before a camera that stands still')
    parser.add_argument(
        '--exposure', type=float, default=0.0, metavar='S',
        help='of a frame, s: it rules out aliases of a frequency (unknown)',
    )
    parser.add_argument(
        '--saturation', type=int, default=0, help='DN of a clipped pixel; 0 is full scale'
    )
    parser.add_argument(
        '--out', type=Path, default=Path('flash.yaml'), metavar='FILE',
        help='parameter file to write (%(default)s); the picture goes beside it, as .png',
    )


def main(arguments: argparse.Namespace) -> None:
    """Look for what blinks; nothing is a failure."""
    check_out(arguments.out, '.png')
    if not 0.0 <= arguments.exposure < 1.0:
        raise UsageError(
            f'--exposure is {arguments.exposure:g} s; it must be 0 to 1 s: 0.005, say'
        )
    console = Console()
    watch, scene = _watch(arguments, console)
    with console.status('looking for what blinks'):
        lights = watch.lights()
    if not lights:
        raise SourceError(_why_none(arguments, watch))
    settings = flash_settings(lights, arguments.exposure)
    _report(console, watch, lights, settings)
    _write(console, arguments, settings, lights)
    picture = arguments.out.with_suffix('.png')
    tell_of(console, picture)
    draw_flash(picture, scene, lights)


def _watch(arguments: argparse.Namespace, console: Console) -> tuple[Watch, Pixels]:
    """Return what was seen in the frames of the source, and the brightest of each pixel."""
    compile_ahead()
    series = longest = _Series(arguments.exposure)
    begun, watched = 1, 0.0
    response = response_of(arguments)
    for _, seconds, pixels, _ in shown_frames(arguments, console, 'watching', live_seconds=LIVE_S):
        if seconds is None:
            raise SourceError(unstamped(arguments))
        full = clipping_level(response, arguments.saturation, pixels)
        frame = Frame(pixels, round(1e9 * seconds), full)
        if series.is_ended_by(frame):
            begun, watched = begun + 1, watched + series.seconds
            series = _Series(arguments.exposure)
        series.push(frame)
        if series.seconds >= longest.seconds:
            longest = series
    if longest.scene is None:
        raise SourceError(f'no image came from {arguments.source}')
    if begun > 1:
        left_out = watched + series.seconds - longest.seconds
        console.print(
            f'- gaps over {LONGEST_GAP_S:g} s, or another size, part the frames into {begun} '
            f'series: the longest is taken, of {longest.seconds:.1f} s; {left_out:.1f} s of '
            'others are left out', highlight=False,
        )
    return longest.watch, longest.scene


class _Series:
    """Frames of one size without a long gap: what was seen in them, and the brightest."""

    def __init__(self, exposure: float) -> None:
        self.watch = Watch(max_pair_interval=LONGEST_GAP_S, exposure=exposure)
        self.scene: Pixels | None = None
        self._segmenter = Segmenter(flash=self.watch)
        self._last: Frame | None = None

    @property
    def seconds(self) -> float:
        return self.watch.found.seconds

    def is_ended_by(self, frame: Frame) -> bool:
        """Tell whether the watch would forget all that it has seen with this frame."""
        if self._last is None:
            return False
        apart = (frame.stamp_ns - self._last.stamp_ns) / 1e9
        now, before = frame.image, self._last.image
        return abs(apart) > LONGEST_GAP_S or now.shape != before.shape or now.dtype != before.dtype

    def push(self, frame: Frame) -> None:
        """Take the next frame; one that is late is told of, and left out."""
        try:
            self._segmenter.update(frame)
        except FrameError as error:
            print(error, file=sys.stderr)
            return
        self._last = frame
        before = frame.image if self.scene is None else self.scene
        self.scene = np.maximum(before, frame.image)


def _why_none(arguments: argparse.Namespace, watch: Watch) -> str:
    """Say why there is no light, and what to do."""
    seconds = watch.found.seconds
    if not seconds:
        return f'{arguments.source} has one frame; a light that blinks takes a second or more'
    _, interval = watch.found.clock
    more = enough(seconds, 1.0 / interval)
    if more:
        return (
            f'nothing blinks in {seconds:.1f} s; record {seconds + more:.0f} s, in which the '
            'slowest light that can be tracked is seen to'
        )
    return (
        f'nothing blinks in {seconds:.1f} s: is the light in the picture, switched on, and '
        'stronger than 5 times the noise? What is always on is not listed'
    )


def _report(
    console: Console, watch: Watch, lights: Sequence[Light], settings: FlashSettings
) -> None:
    """Print the lights, and what is to be said about them."""
    _, interval = watch.found.clock
    console.print(
        f'{watch.found.seconds:.1f} s at {1.0 / interval:.3f} frames/s', highlight=False
    )
    for index, light in enumerate(lights, start=1):
        height, snr = watch.peak(light)
        console.print(
            f'light {index}: {describe(light)}; {height:.0f} DN, SNR {snr:.0f}; at {_place(light)}'
            ' px', markup=False, highlight=False,
        )
        for note in notes(light):
            console.print(f'  - {note}', markup=False, highlight=False)
    for note in settings.notes:
        console.print(f'- {note}', markup=False, highlight=False)
    if watch.found.crowded:
        console.print(
            f'- some frames have more than {MOST_POINTS} points: the brightest were taken'
        )


def _place(light: Light) -> str:
    x, y = light.path.x, light.path.y
    if max(x.std(), y.std()) < STILL_PX:
        return f'{x.mean():.1f}, {y.mean():.1f}'
    return f'{x[0]:.0f}, {y[0]:.0f} to {x[-1]:.0f}, {y[-1]:.0f}'


def _write(
    console: Console, arguments: argparse.Namespace, settings: FlashSettings,
    lights: Sequence[Light],
) -> None:
    """Write the parameter file, and print the parameters to copy."""
    if not settings.values:
        console.print('- none of these can be tracked: nothing is written')
        return
    tell_of(console, arguments.out)
    lines = [
        f'# By `python3 -m blob_tracker calibrate flash {shlex.quote(arguments.source)}`.',
        *(
            f'# {name or f"light {index}"}: {describe(light)}'
            for index, (name, light) in enumerate(zip(settings.named, lights), start=1)
        ),
        '', '/**/segmenter:', '  ros__parameters:',
        *(f'    {name}: {_yaml(value)}' for name, value in settings.values.items()),
    ]
    if settings.lights:
        for node in FOLLOWERS:
            lines += ['', f'/**/{node}:', '  ros__parameters:', f"    lights: '{settings.lights}'"]
    arguments.out.write_text('\n'.join(lines) + '\n')
    words = ' '.join(
        f'-p {name}:={shlex.quote(str(value))}' for name, value in settings.values.items()
    )
    console.print(words, markup=False, highlight=False, soft_wrap=True)
    if settings.lights:
        console.print(
            f'locator and tracker, if each is a process: -p lights:={settings.lights}',
            markup=False, highlight=False, soft_wrap=True,
        )


def _yaml(value: str | float) -> str:
    """Return a value as YAML has it: text in quotes, a code would be a number without."""
    return f"'{value}'" if isinstance(value, str) else f'{value}'
