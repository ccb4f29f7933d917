"""The whole tracker at work: three processes, a live table, a picture, a verdict."""

from __future__ import annotations

import argparse
from collections import deque
from contextlib import ExitStack
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

from ament_index_python.packages import get_package_prefix, PackageNotFoundError
from blob_tracker.commands.child import child
from blob_tracker.commands.monitor import Monitor, RECENT
from blob_tracker.resources import config_path
from blob_tracker.ros.process import shut_down
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

BUDGET = 0.05  # px rms: what the thesis wanted (section 2.1)
LEAST_BEARINGS = 100  # fewer say nothing of an rms
# Its own: a servo on this machine that listens to /target/bearing must not follow a simulation.
NAMESPACE = f'/demo_{os.getpid()}'
STOPPED = 'stopped'
COMPILE = 'from blob_tracker.nodes.locator import compile_default; compile_default()'
STARTUP = 40.0  # s within which the first bearing must come: three on a quiet machine
REFRESH = 0.25  # s between two drawings of the table
LEVELS = {b'\x00': 'green', b'\x01': 'yellow', b'\x02': 'red', b'\x03': 'red'}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `python3 -m blob_tracker demo`."""
    parser.add_argument('--device', help='a V4L2 camera instead of the simulated one')
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
    monitor = Monitor(NAMESPACE)
    try:
        with ExitStack() as stack:
            nodes: dict[str, dict[str, str]] = {'segmenter': {}, 'locator': {}}
            if arguments.device is None:
                nodes['simulator'] = {}
            else:
                nodes['camera'] = _camera_parameters(arguments, console)
            processes = {
                name: stack.enter_context(
                    child([folder / name], NAMESPACE, parameters, out / f'{name}.log')
                )
                for name, parameters in nodes.items()
            }
            fault = _watch(console, monitor, processes, duration)
        return _conclude(console, monitor, out, fault, simulated=arguments.device is None)
    finally:
        monitor.destroy_node()
        shut_down()


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
            if first is None and monitor.bearing is not None:
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
    """Return the live table."""
    table = Table(title='blob_tracker', min_width=64)
    table.add_column('quantity')
    table.add_column('now', justify='right', min_width=12)
    table.add_column('of the run', justify='right', min_width=24)
    if monitor.bearing is not None:
        table.add_row('azimuth (mrad)', f'{monitor.bearing.vector.x:+.3f}', '')
        table.add_row('elevation (mrad)', f'{monitor.bearing.vector.y:+.3f}', '')
    if monitor.ray is not None:
        covariance = monitor.ray.pose.covariance
        sigmas = [MRAD_PER_RAD * covariance[index] ** 0.5 for index in (28, 21)]
        table.add_row('sigma (mrad)', f'{max(sigmas):.4f}', '')
    located, true = monitor.matched()
    if len(located):
        errors = located - true
        rms = np.sqrt(np.mean(errors**2))
        style = 'green' if rms <= BUDGET else 'red'
        table.add_row(
            'error (px)',
            f'{np.hypot(*errors[-1]):.4f}',
            Text(f'{rms:.4f} rms a coordinate', style=style),
        )
    if len(monitor.frames) > 1:
        table.add_row('frames/s', f'{_rate(monitor.frames):.1f}', '')
    if len(monitor.arrivals) > 1:
        table.add_row('bearings/s', f'{_rate(monitor.arrivals):.1f}', f'{len(monitor.centroids)}')
        latencies = 1e3 * np.array(monitor.latencies)
        table.add_row(
            'latency (ms)',
            f'{np.median(latencies[-RECENT:]):.1f}',
            f'{np.median(latencies):.1f} median, {np.percentile(latencies, 99):.1f} p99',
        )
    states = [
        Text(f'{name}: {message}', style=LEVELS.get(level, ''))
        for name, (level, message) in sorted(monitor.states.items())
    ]
    if np.isfinite(duration):
        return Group(table, *states, ProgressBar(duration, min(elapsed, duration), width=64))
    return Group(table, *states, Text('Ctrl-C ends it'))


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
    if simulated:
        located, true = monitor.matched()
        stamps = monitor.matched_stamps()
    else:
        stamps = list(monitor.centroids)
        located, true = np.array(list(monitor.centroids.values())).reshape(-1, 2), None
    if len(located) < (LEAST_BEARINGS if simulated else 2):
        console.print(f'[red]only {len(located)} bearings came: nothing to judge[/red]')
        return 1 if simulated else 0
    covariances = np.array(
        [monitor.pixel_covariance(stamp) for stamp in stamps if stamp in monitor.covariances]
    )
    picture = out / 'demo.png'
    draw_track(picture, located, covariances, true, monitor.size, BUDGET)
    console.print(f'picture: {picture}')
    if true is None:
        return 0
    false = len(monitor.false_stamps())
    if false:
        console.print(f'[red]{false} bearings for frames in which the light was off[/red]')
    rms = float(np.sqrt(np.mean((located - true) ** 2)))
    met = rms <= BUDGET and not false
    console.print(
        f'[{"green" if met else "red"}]{len(located)} bearings, {rms:.4f} px rms a coordinate: '
        f'the budget of {BUDGET} px is {"met" if met else "MISSED"}[/]'
    )
    return 0 if met else 1
