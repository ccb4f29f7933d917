"""The demo as a user runs it: a verdict, a picture, an exit code."""

from __future__ import annotations

from io import StringIO
from pathlib import Path
import re
import signal
import sys

from blob_tracker.camera import CameraModel, pinhole_matrix
from blob_tracker.commands.demo import _conclude, _simulated_parameters, _table, LIGHTS
from blob_tracker.commands.monitor import Monitor
from blob_tracker.flash_text import codes_from_text
from blob_tracker.ros.messages.camera_info import from_camera_model
from blob_tracker.segmentation.patterns import check_patterns
from blob_tracker.simulation import waveforms_of
import cv2
from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import pytest
import rclpy
from rich.console import Console
from support.processes import PATIENCE, probe, Process

MODEL = CameraModel(640, 480, pinhole_matrix(600.0, 640, 480))
INTERVAL_NS = 16_666_667
DEMO = [sys.executable, '-m', 'blob_tracker', 'demo']


def test_demo_meets_its_budget_and_draws_it(tmp_path: Path, domain: int) -> None:
    """Exit code 0 within 30 s, the table, the verdict, and a picture that can be opened."""
    with Process([*DEMO, '--duration', '5', '--out', str(tmp_path)], domain) as demo:
        assert demo.wait(30.0) == 0, demo.output
    for word in ('azimuth (mrad)', 'sigma (mrad)', 'error (px)', 'frames/s', 'latency (ms)'):
        assert word in demo.output
    assert 'the budget of 0.05 px is met' in demo.output
    picture = cv2.imread(str(tmp_path / 'demo.png'))
    assert picture.shape[1] >= 1000


def heard(monitor: Monitor, off: float) -> None:
    """Have a monitor hear 150 places of each light, a tenth of them unsure; one light is off."""
    random = np.random.default_rng(1)
    monitor.camera_info = from_camera_model(MODEL, MODEL.width, MODEL.height)
    for number, (name, light) in enumerate(monitor.lights.items()):
        for index in range(150):
            stamp = 10**18 + index * INTERVAL_NS + random.integers(-10**6, 10**6)
            monitor.stamps.append(10**18 + index * INTERVAL_NS)
            angle = 0.02 * index + number
            x, y = 320.0 + 200.0 * np.sin(angle), 240.0 + 90.0 * np.cos(angle)
            light.truths[stamp] = x, y
            sigma = 0.5 if index % 10 == 0 else 0.02
            light.centroids[stamp] = (
                x + sigma * random.standard_normal() + off * (name == 'mast'),
                y + sigma * random.standard_normal(),
            )
            derivative = MODEL.angles(x, y)[2]
            light.covariances[stamp] = sigma**2 * derivative @ derivative.T / 1e6


@pytest.mark.parametrize('flies', [False, True])
def test_the_segmenter_is_told_the_exposure_that_the_simulator_has(flies: bool) -> None:
    """Told half of it, at another rate, lights that move were at wrong instants: NEES / 2 of 4."""
    nodes = _simulated_parameters(LIGHTS['constellation'][0], flies=flies)
    told, rate = nodes['segmenter']['flash.exposure'], nodes['simulator'].get('rate', '60.0')
    assert nodes['simulator']['flash.exposure'] == told
    assert float(told) < 1.0 / float(rate)


@pytest.mark.parametrize('off, code', [(0.0, 0), (0.1, 1)])
def test_each_light_has_its_column_its_verdict_and_its_picture(
    off: float, code: int, tmp_path: Path, domain: int
) -> None:
    """One that misses the budget fails the demo; unsure glimpses are judged by what they claim."""
    names = LIGHTS['coded'][1]
    rclpy.init(domain_id=domain)
    monitor = Monitor('/demo', lights=names)
    try:
        heard(monitor, off)
        printed = StringIO()
        console = Console(file=printed, width=120)
        console.print(_table(monitor, 1.0, 2.0))
        assert _conclude(console, monitor, tmp_path, '', simulated=True) == code
        said = printed.getvalue()
    finally:
        monitor.destroy_node()
        rclpy.try_shutdown()
    assert all(name in said.splitlines()[2] for name in names)
    verdicts = dict(re.findall(
        r'^(\w+): 150 bearings, 135 of them .* 0.05 px is (\w+)$', said, re.MULTILINE
    ))
    assert verdicts == {name: 'MISSED' if off and name == 'mast' else 'met' for name in names}
    assert {each.name for each in tmp_path.iterdir()} == {f'demo_{name}.png' for name in names}


def test_too_few_bearings_say_how_many_a_verdict_takes(tmp_path: Path, domain: int) -> None:
    """And why there may be so few: a busy machine loses frames."""
    rclpy.init(domain_id=domain)
    monitor = Monitor('/demo', lights=('',))
    try:
        printed = StringIO()
        console = Console(file=printed, width=300)
        assert _conclude(console, monitor, tmp_path, '', simulated=True) == 1
    finally:
        monitor.destroy_node()
        rclpy.try_shutdown()
    said = printed.getvalue()
    assert 'only 0 bearings came, and a verdict takes 100.' in said
    assert 'run it again when it is not' in said


@pytest.mark.parametrize('light', LIGHTS)
def test_what_is_simulated_can_be_looked_for(light: str) -> None:
    """The lights of each choice are those that the segmenter then names."""
    values, names = LIGHTS[light]
    mode = values.get('flash.mode', 'alternate')
    codes = codes_from_text(values.get('flash.codes', ''))
    if codes:
        check_patterns(codes, {}, 0.5)
    assert tuple(codes or ('',)) == names
    if mode != 'alternate':
        assert tuple(waveforms_of(mode, codes=codes)) == names


def test_a_closed_terminal_ends_the_nodes(tmp_path: Path, domain: int) -> None:
    """No node outlives the demo."""
    command = [*DEMO, '--duration', '17', '--out', str(tmp_path)]
    with probe(domain) as node, Process(command, domain) as demo:
        nodes = {'segmenter', 'locator', 'simulator'}
        node.spin_until(lambda: nodes <= set(node.get_node_names()))
        assert demo.end(signal.SIGHUP, timeout=PATIENCE) == 130
        node.spin_until(lambda: set(node.get_node_names()) == {'probe'})
    assert 'Traceback' not in demo.output


def test_demo_on_a_missing_camera_says_so(tmp_path: Path, domain: int) -> None:
    """The camera's own sentence stands under the table until Ctrl-C ends it."""
    command = [*DEMO, '--device', '/dev/no_such_camera', '--out', str(tmp_path)]
    with probe(domain) as node, Process(command, domain) as demo:
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        node.spin_until(lambda: any(
            'there is no such device' in each.status[0].message for each in diagnostics
        ))
        node.settle(2.0)  # until the table shows it
        assert demo.running
        assert demo.end(timeout=PATIENCE) == 0
    assert '/dev/no_such_camera: there is no such device' in demo.output
    assert 'Traceback' not in demo.output
