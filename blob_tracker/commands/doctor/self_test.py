"""The real nodes at work for two seconds: a simulated camera, the segmenter and the locator."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
import os
from pathlib import Path
import random
import re
import subprocess
import sys
import tempfile
import time

from blob_tracker.commands.child import child
from blob_tracker.commands.doctor.compiled import COMPILE
from blob_tracker.commands.doctor.discovery import PORT_BASE, PORTS
from blob_tracker.commands.doctor.finding import error, Finding, ok, warn
from blob_tracker.commands.monitor import Monitor
from blob_tracker.ros.process import shut_down
import numpy as np
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor

NODES = ('simulator', 'segmenter', 'locator')
NAMESPACE = '/blob_tracker_doctor'
SECONDS = 2.0  # of tracking
STARTUP = 20.0  # s within which the first bearing must come, on a busy machine
LATE = 0.3  # s that the last bearings may be under way
COMPILING = 300.0  # s, on a slow machine
BUDGET = 0.05  # px rms: what the thesis wanted (section 2.1)
FRAME = 1.0 / 60.0  # s from one frame of the simulator to the next
SLOW = 0.9  # of the frame rate: below it something takes the time away
TOLERATED = 0.02  # share of lit frames that may be lost
COLOUR = re.compile(r'\x1b\[[0-9;]*m')
LAST_DOMAIN = 101  # the ports of the next run into those that Linux gives to anybody
NO_LOGS = ['--ros-args', '--disable-external-lib-logs']  # their folder has its own check
METHODS = ['maximum_likelihood']  # the default: compiling all of them takes several times as long
# On this machine, in a domain of its own, and not secured: the keys are for other names.
NOT_INHERITED = (
    'ROS_LOCALHOST_ONLY', 'ROS_STATIC_PEERS', 'ROS_DISCOVERY_SERVER', 'ROS_SECURITY_ENABLE',
    'ROS_NAMESPACE',
)


@dataclass(frozen=True)
class Run:
    """
    What came of a run.

    Parameters
    ----------
    domain : int
        ROS domain that it took place in.
    fault : str
        Why there was none, '' where there was.
    rate : float
        Frames/s of the simulated camera, which makes 60 where it gets the time.
    lit : int
        Frames in which the light was on.
    located : int
        Those of them for which there was a bearing.
    false : int
        Bearings for other frames.
    rms : float
        Of the error of a coordinate, px.
    latency : float
        Median time from the stamp of a frame to the arrival of its bearing, s.
    latency_p99 : float
        The same, of which all but a hundredth stay below, s.

    """

    domain: int
    fault: str = ''
    rate: float = 0.0
    lit: int = 0
    located: int = 0
    false: int = 0
    rms: float = float('nan')
    latency: float = float('nan')
    latency_p99: float = float('nan')


def check_tracking(environment: Mapping[str, str], folder: Path | None) -> Iterator[Finding]:
    """
    Run the nodes and judge what they publish.

    Parameters
    ----------
    environment : mapping
        Environment variables.
    folder : Path or None
        Of the executables; None starts the nodes of the package that Python imports.

    """
    yield judge(track(environment, folder))


def judge(run: Run) -> Finding:
    """Return the finding on a run."""
    if run.fault:
        return error('self-test', run.fault)
    lost = run.lit - run.located
    words = (
        f'{run.located} bearings in {SECONDS:g} s from a simulated camera, three processes, '
        f'{run.rate:.0f} frames/s, domain {run.domain}: '
        f'{run.rms:.4f} px rms a coordinate (budget {BUDGET}), latency '
        f'{1e3 * run.latency:.1f} ms median and {1e3 * run.latency_p99:.1f} ms p99, {lost} of '
        f'{run.lit} lit frames lost'
    )
    if run.false:
        return error('self-test', f'{words}; {run.false} bearings for frames without light')
    if not run.rms <= BUDGET:
        return error('self-test', f'{words}: the budget is missed')
    if lost > TOLERATED * run.lit:
        return warn(
            'self-test', words,
            'the profile of Fast DDS, shared memory, or what else keeps this machine busy: see '
            'above, and top',
        )
    if run.latency > FRAME or run.rate < SLOW / FRAME:
        return warn(
            'self-test', words,
            f'{1.0 / FRAME:.0f} frames/s should come, and a bearing before the next frame, in '
            f'{1e3 * FRAME:.1f} ms: see with top what keeps this machine busy',
        )
    return ok('self-test', words)


def free_domain(udp: str, low: int = 1, high: int = LAST_DOMAIN) -> int:
    """
    Return a ROS domain of which no port is taken, at random; any where all are.

    Parameters
    ----------
    udp : str
        What /proc/net/udp says.
    low, high : int
        The domains to choose from.

    """
    ports = {int(line.split()[1].rpartition(':')[2], 16) for line in udp.splitlines()[1:]}
    taken = {(port - PORT_BASE) // PORTS for port in ports}
    domains = range(low, high + 1)
    return random.choice([d for d in domains if d not in taken] or domains)


def track(environment: Mapping[str, str], folder: Path | None) -> Run:
    """Run the nodes for a while, and compare what they publish with the truth."""
    domain = free_domain(Path('/proc/net/udp').read_text())
    own = {name: value for name, value in environment.items() if name not in NOT_INHERITED}
    own |= {'ROS_DOMAIN_ID': str(domain), 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    with tempfile.TemporaryDirectory(prefix='blob_tracker_doctor_') as name:
        logs = Path(name)
        # Elsewhere than here: Python would take the package of this folder, and not the nodes'.
        place = None if folder is None else logs
        result = subprocess.run(
            [sys.executable, '-c', COMPILE.format(METHODS)], cwd=place, env=own, timeout=COMPILING,
            capture_output=True, text=True,
        )
        if result.returncode:
            last = (result.stderr.strip().splitlines() or ['it says nothing'])[-1]
            return Run(domain, f'the fits cannot be compiled: {last}')
        before = dict(os.environ)
        _become(own)  # rclpy and Fast DDS read that of the process
        try:
            return _measure(domain, own, folder, logs)
        finally:
            _become(before)


def _become(environment: Mapping[str, str]) -> None:
    """Make the environment variables of this process these."""
    os.environ.clear()
    os.environ.update(environment)


def _measure(domain: int, own: Mapping[str, str], folder: Path | None, logs: Path) -> Run:
    """Run the nodes in an environment that this process has as well."""
    context = Context()
    rclpy.init(args=NO_LOGS, context=context, domain_id=domain)
    monitor = Monitor(NAMESPACE, context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(monitor)
    try:
        with ExitStack() as stack:
            processes = {
                node: stack.enter_context(
                    child(_command(node, folder), NAMESPACE, {}, logs / f'{node}.log', own)
                )
                for node in NODES
            }
            fault = _listen(executor, monitor, processes, logs)
        if fault:
            return Run(domain, fault)
        return _compare(domain, monitor)
    finally:
        monitor.destroy_node()
        shut_down(context)


def _command(node: str, folder: Path | None) -> Sequence[str | Path]:
    if folder is not None:
        return [folder / node]
    return [sys.executable, '-c', f'from blob_tracker.nodes import start; start.{node}()']


def _listen(
    executor: SingleThreadedExecutor,
    monitor: Monitor,
    processes: Mapping[str, subprocess.Popen[bytes]],
    logs: Path,
) -> str:
    """Take what the nodes publish from the first bearing on; return what went wrong, or ''."""
    end = time.monotonic() + STARTUP
    tracking = False
    while time.monotonic() < end:
        executor.spin_once(timeout_sec=max(end - time.monotonic(), 0.0))
        for node, process in processes.items():
            if process.poll() is not None:
                words = _last_words(logs, node)
                return f'the {node} ended with exit code {process.returncode}{words}'
        if not tracking and monitor.lights[''].bearing is not None:
            tracking = True
            monitor.forget()  # the nodes have found each other, one after the other
            end = time.monotonic() + SECONDS + LATE
    return '' if tracking else f'no bearing came within {STARTUP:.0f} s{_last_words(logs)}'


def _compare(domain: int, monitor: Monitor) -> Run:
    """Return how the bearings compare with the truth, without the last that are under way."""
    light = monitor.lights['']
    last = max(light.truths, default=0) - int(1e9 * LATE)
    lit = [stamp for stamp in light.truths if stamp <= last]
    located = [stamp for stamp in lit if stamp in light.centroids]
    if not located:
        return Run(domain, 'bearings came, and then no more')
    errors = np.array([
        np.subtract(light.centroids[stamp], light.truths[stamp]) for stamp in located
    ])
    return Run(
        domain,
        rate=2e9 * (len(lit) - 1) / max(lit[-1] - lit[0], 1),  # the light is in every other one
        lit=len(lit),
        located=len(located),
        false=len(light.false_stamps(monitor.interval_ns)),
        rms=float(np.sqrt(np.mean(errors**2))),
        latency=float(np.median(light.latencies)),
        latency_p99=float(np.percentile(light.latencies, 99)),
    )


def _last_words(logs: Path, node: str = '*') -> str:
    """Return the last line that a node, or each, has logged."""
    words = ''
    for log in sorted(logs.glob(f'{node}.log')):
        lines = COLOUR.sub('', log.read_text(errors='replace')).strip().splitlines()
        words += f'; {log.stem}: {lines[-1] if lines else "says nothing"}'
    return words
