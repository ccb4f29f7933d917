"""The whole tracker at work: three processes, a live table, a picture, a verdict."""

from __future__ import annotations

import argparse
from collections import deque
from collections.abc import Mapping
from contextlib import ExitStack
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

from ament_index_python.packages import get_package_prefix, PackageNotFoundError
from blob_tracker.commands.child import child
from blob_tracker.commands.monitor import Monitor
from blob_tracker.commands.watched_body import WatchedBody
from blob_tracker.commands.watched_light import BUDGET, RECENT, Score, WatchedLight
from blob_tracker.constellation import read_body
from blob_tracker.resources import config_path
from blob_tracker.ros.process import shut_down
from blob_tracker.studies.flight_report import draw_flight
from blob_tracker.studies.track_report import draw_track
from blob_tracker.units import MRAD_PER_RAD
import numpy as np
import rclpy
from rclpy.executors import ExternalShutdownException
from rich.console import Console, Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

MM_PER_M = 1e3
LEAST_BEARINGS = 100  # fewer say nothing of an rms
# Its own: a servo on this machine that listens to /target/bearing must not follow a simulation.
NAMESPACE = f'/demo_{os.getpid()}'
STOPPED = 'stopped'
COMPILE = (
    'from blob_tracker.pipeline import compile_ahead; compile_ahead(["maximum_likelihood"])\n'
    'from blob_tracker.constellation import compile_ahead; compile_ahead()'
)
# Rows of the table. The light that a frame shows for a moment is placed as badly as its sigma
# says; the budget is for those bearings that claim to be within it.
RMS = f'rms where sigma <= {BUDGET} px (px)'
ROWS = (
    'azimuth (mrad)', 'elevation (mrad)', 'sigma (mrad)', 'error (px)', RMS, 'bearings',
    'bearings/s', 'latency (ms)', 'latency, p99 (ms)',
)
# Greatest scatter / sigma, whose right value is 1: three standard errors above it with the
# fewest bearings, whose noise is not quite Gaussian.
MOST_SCATTER = 1.5
# The least of a body, whose lights are off their places in its file by the same in each pose.
LEAST_SCATTER = 0.5
IN_STEP = 'in_step'
# By the names of --light: parameters of simulator and segmenter, and the names of the lights.
LIGHTS: dict[str, tuple[dict[str, str], tuple[str, ...]]] = {
    IN_STEP: ({}, ('',)),
    # Seen by 60 frames a second it is never twice in the same phase.
    'free': ({'flash.mode': 'periodic', 'flash.frequency': '13.7'}, ('',)),
    'coded': (
        {
            'flash.mode': 'coded',
            'flash.codes': 'port:1110001000,starboard:1100100100,mast:1101101010',
            'flash.bits_per_second': '40.0',
        },
        ('port', 'starboard', 'mast'),
    ),
}
# What the segmenter looks for with a real camera, by the names of --light.
SOUGHT = {IN_STEP: {}, 'free': {'flash.mode': 'auto'}}
CONSTELLATION = 'constellation'
LIGHTS[CONSTELLATION] = (
    {
        'flash.mode': 'coded',
        'flash.codes': 'nose:1111010010,port:1111110100,starboard:1111011010,tail:1110111010,'
        'mast:1110010110',
        'flash.bits_per_second': '20.0',
    },
    ('nose', 'port', 'starboard', 'tail', 'mast'),
)
BODY, BODY_URL = 'drone', 'package://blob_tracker/config/drone.yaml'
FLIGHT = {'speed_sigma': '0.5', 'rate_sigma': '0.6'}  # m/s and rad/s, as it flies
RATE = '30.0'  # Hz: five lights are more work for each frame
LEAST_POSES = 20
CLOCK_ERROR = '0.003'  # of lights that run free: more than that of any quartz
EXPOSURE = '0.008333'  # s, of all scenes: half of the frame interval at 60 Hz
STARTUP = 40.0  # s within which the first bearing must come: three on a quiet machine
FEW, WIDE, NARROW = 3, 12, 8  # lights whose columns are wide, and columns, characters
REFRESH = 0.25  # s between two drawings of the table
LEVELS = {b'\x00': 'green', b'\x01': 'yellow', b'\x02': 'red', b'\x03': 'red'}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `python3 -m blob_tracker demo`."""
    parser.add_argument('--device', help='a V4L2 camera instead of the simulated one')
    parser.add_argument(
        '--light',
        choices=tuple(LIGHTS),
        default=IN_STEP,
        help='what is simulated: a light in step with the camera, one that runs free at 13.7 Hz, '
        'three that blink codes, or five of them on a drone, whose pose is shown; a real camera '
        'looks for one in step, or one that runs free at whatever frequency',
    )
    parser.add_argument(
        '--camera-info', help='its calibration; without one a lens of 60 degrees is assumed'
    )
    parser.add_argument(
        '--duration', type=float, default=15.0, help='seconds of tracking, at most 17 (simulated)'
    )
    parser.add_argument('--out', type=Path, default=Path('out'), help='for picture and logs')


def main(arguments: argparse.Namespace) -> int:
    """
    Run the demo.

    Parameters
    ----------
    arguments : Namespace
        Of the parser that `add_arguments` filled.

    Returns
    -------
    int
        0 where the error budget was met (simulated) or Ctrl-C ended it (real camera), else 1.

    """
    console = Console()
    out: Path = arguments.out
    if arguments.device is not None and arguments.light not in SOUGHT:
        console.print(
            f'--light {arguments.light} is simulated: leave out --device; for your own lights, '
            f'python3 -m blob_tracker calibrate flash {arguments.device} finds their codes',
            soft_wrap=True,
        )
        return 2
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        console.print(f'--out {out} cannot be made: {error.strerror}')
        return 2
    os.environ.setdefault('FASTRTPS_DEFAULT_PROFILES_FILE', str(config_path('fastdds.xml')))
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    try:
        folder = Path(get_package_prefix('blob_tracker')) / 'lib' / 'blob_tracker'
    except PackageNotFoundError:
        console.print(
            'blob_tracker is not installed for ROS here: run `make demo`, or `colcon build` and '
            '`source install/setup.bash`'
        )
        return 1
    with console.status('compiling the fits, if they are not yet'):
        # In the package that the nodes load, which need not be the one that this is run from.
        subprocess.run([sys.executable, '-c', COMPILE], cwd=out, check=True)
    duration = min(arguments.duration, 17.0) if arguments.device is None else float('inf')
    rclpy.init()
    # A terminal that is closed ends the nodes as Ctrl-C does: they are in sessions of their own.
    signal.signal(signal.SIGHUP, signal.default_int_handler)
    if arguments.device is None:
        parameters, lights = LIGHTS[arguments.light]
    else:
        parameters, lights = SOUGHT[arguments.light], ('',)
    flies = arguments.light == CONSTELLATION
    monitor = Monitor(NAMESPACE, lights=lights, body=BODY if flies else '')
    try:
        with ExitStack() as stack:
            if arguments.device is None:
                nodes = _simulated_parameters(parameters, flies=flies)
            else:
                nodes = {
                    'segmenter': {**parameters},
                    'camera': _camera_parameters(arguments, console),
                }
            nodes['locator'] = {} if lights == ('',) else {'lights': ','.join(lights)}
            processes = {
                name: stack.enter_context(
                    child([folder / name], NAMESPACE, values, out / f'{name}.log')
                )
                for name, values in nodes.items()
            }
            fault = _watch(console, monitor, processes, duration)
        return _conclude(console, monitor, out, fault, simulated=arguments.device is None)
    finally:
        monitor.destroy_node()
        shut_down()


def _simulated_parameters(
    parameters: Mapping[str, str], *, flies: bool
) -> dict[str, dict[str, str]]:
    """Return those of the nodes that differ from their defaults, by node, before a simulation."""
    nodes = {'segmenter': {**parameters}, 'simulator': {**parameters}}
    if parameters:
        # One is told what the other does, whatever the rate.
        nodes['segmenter']['flash.exposure'] = nodes['simulator']['flash.exposure'] = EXPOSURE
        nodes['simulator']['clock_error'] = CLOCK_ERROR
    if flies:
        nodes['simulator'].update(body_url=BODY_URL, rate=RATE)
        nodes['constellation'] = {'body': BODY, 'body_url': BODY_URL, **FLIGHT}
    return nodes


def _camera_parameters(arguments: argparse.Namespace, console: Console) -> dict[str, str]:
    """Return the parameters of the camera node."""
    if arguments.camera_info:
        calibration = {'camera_info_url': str(arguments.camera_info)}
    else:
        calibration = {'field_of_view': '60.0'}
        console.print(
            'No calibration is given: angles are for a lens that sees 60 degrees across. '
            'Set CAMERA_INFO=FILE for true ones.'
        )
    return {'device': str(arguments.device), **calibration}


def _watch(
    console: Console,
    monitor: Monitor,
    processes: dict[str, subprocess.Popen[bytes]],
    duration: float,
) -> str:
    """Show the live table until the time is over or Ctrl-C; return what went wrong, or ''."""
    simulated = 'simulator' in processes
    began = time.monotonic()
    first: float | None = None
    drawn = 0.0
    with Live(console=console, auto_refresh=False) as live:
        while True:
            try:
                rclpy.spin_once(monitor, timeout_sec=REFRESH)
            except (KeyboardInterrupt, ExternalShutdownException):
                return STOPPED if simulated else ''
            now = time.monotonic()
            if now - drawn < REFRESH:  # drawing takes time that the latencies must not show
                continue
            drawn = now
            if first is None and all(each.bearing for each in monitor.lights.values()):
                first = now
            for name, process in processes.items():
                if process.poll() is not None:
                    return f'{name} ended with exit code {process.returncode}'
            if simulated and first is None and now - began > STARTUP:
                return f'no bearing within {STARTUP:.0f} s'
            elapsed = 0.0 if first is None else now - first
            live.update(_table(monitor, elapsed, duration), refresh=True)
            if elapsed > duration:
                return ''


def _table(monitor: Monitor, elapsed: float, duration: float) -> Group:
    """Return the live table: a column for each light."""
    table = Table(title='blob_tracker', min_width=72)
    table.add_column('quantity')
    columns = [_column(monitor, light) for light in monitor.lights.values()]
    width = WIDE if len(columns) <= FEW else NARROW
    for name in monitor.lights:
        table.add_column(name or 'now', justify='right', min_width=width)
    for quantity in ROWS:
        if any(quantity in column for column in columns):
            table.add_row(quantity, *(column.get(quantity, '') for column in columns))
    if len(monitor.frames) > 1:
        table.add_row('frames/s', f'{_rate(monitor.frames):.1f}')
    bodies = [] if monitor.body is None else [_of_body(monitor.body)]
    states = [
        Text(f'{name}: {message}', style=LEVELS.get(level, ''))
        for name, (level, message) in sorted(monitor.states.items())
    ]
    if np.isfinite(duration):
        bar = ProgressBar(duration, min(elapsed, duration), width=64)
        return Group(table, *bodies, *states, bar)
    return Group(table, *bodies, *states, Text('Ctrl-C ends it'))


def _column(monitor: Monitor, light: WatchedLight) -> dict[str, Text]:
    """Return what is known of a light, by the names of `ROWS`."""
    found: dict[str, str] = {}
    if light.bearing is not None:
        found['azimuth (mrad)'] = f'{light.bearing.vector.x:+.3f}'
        found['elevation (mrad)'] = f'{light.bearing.vector.y:+.3f}'
    if light.ray is not None:
        covariance = light.ray.pose.covariance
        sigmas = [MRAD_PER_RAD * covariance[index] ** 0.5 for index in (28, 21)]
        found['sigma (mrad)'] = f'{max(sigmas):.4f}'
    score = _score(monitor, light)
    if score is not None:
        found['error (px)'] = f'{np.hypot(*score.errors[-1]):.4f}'
        found[RMS] = f'{score.rms:.4f}'
    if len(light.arrivals) > 1:
        found['bearings'] = f'{len(light.centroids)}'
        found['bearings/s'] = f'{_rate(light.arrivals):.1f}'
        latencies = 1e3 * np.array(light.latencies)
        found['latency (ms)'] = f'{np.median(latencies[-RECENT:]):.1f}'
        found['latency, p99 (ms)'] = f'{np.percentile(latencies, 99):.1f}'
    column = {quantity: Text(value) for quantity, value in found.items()}
    if score is not None:
        column[RMS].stylize('green' if score.rms <= BUDGET else 'red')
    return column


def _of_body(body: WatchedBody) -> Table:
    """Return the table of a body's pose."""
    table = Table(title=body.name, min_width=72)
    for name in ('x, y, z (m)', 'position off (mm rms)', 'rotation off (degrees rms)', 'poses/s'):
        table.add_column(name, justify='right')
    score = body.score()
    if score is not None:
        place, turn = score.rms
        x, y, z = score.positions[-1]
        table.add_row(
            f'{x:+.3f} {y:+.3f} {z:.3f}', f'{MM_PER_M * place:.2f}', f'{np.degrees(turn):.3f}',
            f'{_rate(body.arrivals):.1f}' if len(body.arrivals) > 1 else '',
        )
    return table


def _rate(times: deque[float]) -> float:
    """Return the events a second."""
    return (len(times) - 1) / max(times[-1] - times[0], 1e-9)


def _conclude(
    console: Console, monitor: Monitor, out: Path, fault: str, *, simulated: bool
) -> int:
    """Write the picture, print the verdict, and return the exit code."""
    console.print()  # the live table ends without a line break
    if fault == STOPPED:
        console.print('stopped before the verdict')
        return 130
    if fault:
        console.print(f'[red]{fault}[/red]; the logs are in {out}/')
        for log in sorted(out.glob('*.log')):
            lines = log.read_text(errors='replace').splitlines()[-5:]
            console.print(*[f'  {log.stem}: {line}' for line in lines], sep='\n', markup=False)
        return 1
    if monitor.body is not None:  # of its lights that hide one another more is asked than of one
        return _judge_body(console, monitor.body, out / 'demo_pose.png')
    codes = [
        _judge(console, monitor, name, out / f'demo{f"_{name}" if name else ""}.png', simulated)
        for name in monitor.lights
    ]
    return max(codes)


def _judge_body(console: Console, body: WatchedBody, picture: Path) -> int:
    """Draw a body's flight, print its verdict, and return the exit code."""
    score = body.score()
    count = 0 if score is None else len(score.times)
    if score is None or count < LEAST_POSES:
        console.print(_too_few(f'{body.name}: only {count} poses', LEAST_POSES))
        return 1
    lights = read_body(config_path('drone.yaml')).places
    draw_flight(picture, score.times, score.true, score.true_turns, score.positions, score.turns,
                score.errors, score.covariances, lights)
    console.print(f'picture: {picture}')
    place, turn = score.rms
    met = LEAST_SCATTER <= score.scatter <= MOST_SCATTER
    verdict = 'as' if met else 'MORE than' if score.scatter > MOST_SCATTER else 'LESS than'
    console.print(
        f'[{"green" if met else "red"}]{body.name}: {count} poses, the position '
        f'{MM_PER_M * place:.1f} mm rms off, the rotation {np.degrees(turn):.2f} degrees, '
        f'scatter / sigma {score.scatter:.2f}: {verdict} the covariances say[/]',
        soft_wrap=True,
    )
    return 0 if met else 1


def _too_few(came: str, least: int) -> str:
    """Return what is said where a verdict would mean nothing; the nodes' words stand above it."""
    return (
        f'[red]{came} came, and a verdict takes {least}. If a node says above that frames are '
        'missing, the processor is busy with something else: run it again when it is not[/red]'
    )


def _judge(
    console: Console, monitor: Monitor, name: str, picture: Path, simulated: bool
) -> int:
    """Write a light's picture, print its verdict, and return the exit code."""
    light, about = monitor.lights[name], f'{name}: ' if name else ''
    score = _score(monitor, light) if simulated else None
    count = len(light.centroids) if score is None else len(score.errors)
    least = LEAST_BEARINGS if simulated else 2
    if count < least:
        console.print(_too_few(f'{about}only {count} bearings', least))
        return 1 if simulated else 0
    if score is None:
        stamps = [stamp for stamp in light.centroids if stamp in light.covariances]
        located = np.array([light.centroids[stamp] for stamp in stamps]).reshape(-1, 2)
        covariances = np.array([monitor.pixel_covariance(light, stamp) for stamp in stamps])
        draw_track(picture, located, covariances, None, monitor.size, BUDGET)
        console.print(f'picture: {picture}')
        return 0
    draw_track(
        picture, score.located, score.covariances, score.located - score.errors, monitor.size,
        BUDGET,
    )
    console.print(f'picture: {picture}')
    false = len(light.false_stamps(monitor.interval_ns))
    if false:
        console.print(f'[red]{about}{false} bearings for frames in which the light was off[/red]')
    accurate, honest = score.rms <= BUDGET, score.scatter <= MOST_SCATTER
    met = accurate and honest and not false
    console.print(
        f'[{"green" if met else "red"}]{about}{score.words}: errors '
        f'{"as" if honest else "LARGER than"} the covariances say, and the budget of {BUDGET} px '
        f'is {"met" if accurate else "MISSED"}[/]',
        soft_wrap=True,
    )
    return 0 if met else 1


def _score(monitor: Monitor, light: WatchedLight) -> Score | None:
    """Hold a light's locations against the truth; None if there are none."""
    stamps = light.matched_stamps(monitor.interval_ns)
    located, true = light.matched(monitor.interval_ns)
    known = [index for index, stamp in enumerate(stamps) if stamp in light.covariances]
    if not known:
        return None
    covariances = np.array([monitor.pixel_covariance(light, stamps[each]) for each in known])
    return Score(located[known], located[known] - true[known], covariances)
