"""The whole tracker at work: three processes, a live table, a picture, a verdict."""

from __future__ import annotations

import argparse
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, ExitStack
import os
from pathlib import Path
import signal
import subprocess
import sys
import time
from typing import Any

from ament_index_python.packages import get_package_prefix, PackageNotFoundError
from blob_tracker.camera.model import MRAD
from blob_tracker.resources import config_path
from blob_tracker.ros.camera_info import to_camera_model
from blob_tracker.ros.qos import IMAGE_IN, RESULT
from blob_tracker.ros.stamp import to_ns
from blob_tracker.studies.track_report import draw_track
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped, Vector3Stamped
import numpy as np
from numpy.typing import NDArray
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rich.console import Console, Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text
from sensor_msgs.msg import CameraInfo

BUDGET = 0.05  # px rms: what the thesis wanted (section 2.1)
LEAST_BEARINGS = 100  # fewer say nothing of an rms
# Its own: a servo on this machine that listens to /target/bearing must not follow a simulation.
NAMESPACE = f'/demo_{os.getpid()}'
STOPPED = 'stopped'
COMPILE = 'from blob_tracker.nodes.locator import compile_default; compile_default()'
STARTUP = 12.0  # s within which the first bearing must come
LONGEST = 20_000  # frames that are remembered: ten minutes
WHOLE = 26.0  # s from the start of the nodes to the verdict, at most
RECENT = 60  # bearings over which rates and latencies are taken
REFRESH = 0.25  # s between two drawings of the table
GRACE = 2.0  # s that a node has to end by itself
LEVELS = {b'\x00': 'green', b'\x01': 'yellow', b'\x02': 'red', b'\x03': 'red'}


class Monitor(Node):
    """Collect what the tracker publishes, and the truth where there is one."""

    def __init__(self) -> None:
        super().__init__('monitor', namespace=NAMESPACE)
        self.frames: deque[float] = deque(maxlen=2 * RECENT)
        self.latencies: deque[float] = deque(maxlen=LONGEST)
        self.arrivals: deque[float] = deque(maxlen=RECENT)
        self.camera_info = CameraInfo()
        self.bearing: Vector3Stamped | None = None
        self.ray: PoseWithCovarianceStamped | None = None
        self.centroids: dict[int, tuple[float, float]] = {}
        self.covariances: dict[int, NDArray[np.float64]] = {}
        self.truths: dict[int, tuple[float, float]] = {}
        self.states: dict[str, tuple[bytes, str]] = {}
        self.create_subscription(CameraInfo, 'camera/camera_info', self._camera_info, IMAGE_IN)
        for kind, topic, callback in (
            (Vector3Stamped, 'target/bearing', self._bearing),
            (PoseWithCovarianceStamped, 'target/ray', self._ray),
            (PointStamped, 'target/centroid', self._centroid),
            (PointStamped, 'simulator/truth/centroid', self._truth),
            (DiagnosticArray, '/diagnostics', self._diagnostics),
        ):
            self.create_subscription(kind, topic, callback, RESULT)

    def pixel_covariance(self, stamp: int) -> NDArray[np.float64]:
        """Return the (2, 2) covariance of a location, px^2, from that of its ray, rad^2."""
        model = to_camera_model(self.camera_info)
        _, _, derivative = model.angles(*self.centroids[stamp])
        inverse = MRAD * np.linalg.inv(derivative)
        return inverse @ self.covariances[stamp] @ inverse.T

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the frames, px."""
        return self.camera_info.width, self.camera_info.height

    def matched_stamps(self) -> list[int]:
        """Return the stamps of the frames that have a location and a truth, in their order."""
        return sorted(stamp for stamp in self.centroids if stamp in self.truths)

    def false_stamps(self) -> list[int]:
        """Return the stamps of locations in frames in which the light was not on."""
        if not self.truths:
            return []
        # Before the first truth and after the last it may still be under way.
        return [s for s in self.centroids if min(self.truths) < s < max(self.truths)
                and s not in self.truths]

    def matched(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the (N, 2) locations and true places of the frames that have both, px."""
        stamps = self.matched_stamps()
        located = np.array([self.centroids[stamp] for stamp in stamps]).reshape(-1, 2)
        return located, np.array([self.truths[stamp] for stamp in stamps]).reshape(-1, 2)

    def _camera_info(self, message: CameraInfo) -> None:
        self.frames.append(time.monotonic())
        self.camera_info = message

    def _bearing(self, message: Vector3Stamped) -> None:
        self.latencies.append(time.time() - to_ns(message.header.stamp) / 1e9)
        self.arrivals.append(time.monotonic())
        self.bearing = message

    def _ray(self, message: PoseWithCovarianceStamped) -> None:
        self.ray = message
        covariance = np.array(message.pose.covariance).reshape(6, 6)
        self._keep(self.covariances, message, covariance[np.ix_([4, 3], [4, 3])])

    def _centroid(self, message: PointStamped) -> None:
        self._keep(self.centroids, message, (message.point.x, message.point.y))

    def _truth(self, message: PointStamped) -> None:
        self._keep(self.truths, message, (message.point.x, message.point.y))

    @staticmethod
    def _keep(store: dict[int, Any], message: Any, value: Any) -> None:
        """Store a value by its stamp; a demo on a real camera may run for days."""
        store[to_ns(message.header.stamp)] = value
        if len(store) > LONGEST:
            del store[next(iter(store))]

    def _diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            name = status.name.split(':')[0]
            if name.startswith(NAMESPACE):
                self.states[name.rpartition('/')[2]] = (status.level, status.message)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `python -m blob_tracker demo`."""
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
    monitor = Monitor()
    try:
        with ExitStack() as stack:
            nodes: dict[str, dict[str, str]] = {'segmenter': {}, 'locator': {}}
            if arguments.device is None:
                nodes['simulator'] = {}
            else:
                nodes['camera'] = _camera_parameters(arguments, console)
            processes = {
                name: stack.enter_context(_process(folder / name, parameters, out))
                for name, parameters in nodes.items()
            }
            fault = _watch(console, monitor, processes, duration)
        return _conclude(console, monitor, out, fault, simulated=arguments.device is None)
    finally:
        monitor.destroy_node()
        rclpy.try_shutdown()


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


@contextmanager
def _process(
    executable: Path, parameters: dict[str, str], out: Path
) -> Iterator[subprocess.Popen[bytes]]:
    """Run a node with its output in a log file, and end it with the block."""
    command = [str(executable), '--ros-args', '-r', f'__ns:={NAMESPACE}']
    for name, value in parameters.items():
        command += ['-p', f'{name}:={value}']
    with open(out / f'{executable.name}.log', 'wb') as log:
        # A session of its own: Ctrl-C reaches the demo alone, which ends the nodes in order.
        process = subprocess.Popen(
            command,
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            yield process
        finally:
            process.send_signal(signal.SIGINT)
            try:
                process.wait(GRACE)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


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
            if elapsed > duration or (simulated and now - began > WHOLE):
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
        sigmas = [1e3 * covariance[index] ** 0.5 for index in (28, 21)]
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
