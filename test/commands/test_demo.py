"""The demo as a user runs it: a verdict, a picture, an exit code."""

from __future__ import annotations

from pathlib import Path
import re
import signal
import sys

import cv2
from diagnostic_msgs.msg import DiagnosticArray
from support.processes import probe, Process

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


def test_coded_lights_that_move_meet_it_too(tmp_path: Path, domain: int) -> None:
    """A verdict and a picture of each, against the truth at the instants of the bearings."""
    names = ['port', 'starboard', 'mast']
    command = [*DEMO, '--light', 'coded', '--duration', '6', '--out', str(tmp_path)]
    with Process(command, domain) as demo:
        assert demo.wait(40.0) == 0, demo.output
    verdicts = re.findall(r'^(\w+): .* the budget of 0.05 px is met$', demo.output, re.MULTILINE)
    assert set(verdicts) == set(names)
    for name in names:
        assert (tmp_path / f'demo_{name}.png').exists()


def test_a_closed_terminal_ends_the_nodes(tmp_path: Path, domain: int) -> None:
    """No node outlives the demo."""
    command = [*DEMO, '--duration', '17', '--out', str(tmp_path)]
    with probe(domain) as node, Process(command, domain) as demo:
        nodes = {'segmenter', 'locator', 'simulator'}
        node.spin_until(lambda: nodes <= set(node.get_node_names()))
        assert demo.end(signal.SIGHUP, timeout=10.0) == 130
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
        assert demo.end(timeout=10.0) == 0
    assert '/dev/no_such_camera: there is no such device' in demo.output
    assert 'Traceback' not in demo.output
