"""Nodes start from where `ros2 run` finds them, refuse wrong parameters, and end at once."""

from __future__ import annotations

import os
from pathlib import Path
import signal
import subprocess
import sys
import time

from blob_tracker.nodes import NODES
from blob_tracker.nodes.start import publishes_images
from geometry_msgs.msg import Vector3Stamped
import pytest
from support.processes import PATIENCE, probe, start
from support.slowness import slowness

ATTEMPTS = 3  # a busy machine may be late once; a node that hangs is late each time


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize('name', NODES)
def test_ends_on_a_signal_without_a_trace(name: str, number: int, domain: int) -> None:
    """Exit code 0 within 1 s of Ctrl-C or SIGTERM, and nothing on the terminal about it."""
    with probe(domain) as node:
        for _ in range(ATTEMPTS):
            with start(name, domain) as process:
                node.spin_until(lambda: name in node.get_node_names())
                began = time.monotonic()
                assert process.end(number) == 0
                took = time.monotonic() - began
            assert 'Traceback' not in process.output
            assert 'Error' not in process.output
            if took < 1.0 * slowness():
                return
            node.spin_until(lambda: name not in node.get_node_names())
    assert took < 1.0 * slowness()


@pytest.mark.parametrize('pause', [0.0, 0.013, 0.026])
def test_ctrl_c_in_the_midst_of_predictions_leaves_no_trace(pause: float, domain: int) -> None:
    """A thousand of them a second: the signal comes in a callback that publishes."""
    with probe(domain) as node, start(
        'pipeline', domain, source='simulator', width=160, height=120, prediction_rate=1000.0
    ) as process:
        predictions = node.record(Vector3Stamped, 'target/bearing_predicted')
        node.spin_until(lambda: len(predictions) > 100)
        time.sleep(pause)
        assert process.end(signal.SIGINT) == 0
    assert 'Traceback' not in process.output
    assert 'invalid' not in process.output


@pytest.mark.parametrize(
    'name, parameters, sentence',
    [
        ('camera', {'buffers': 1}, "'buffers' is 1; it must be an integer from 2 to 32"),
        ('camera', {'frame_rate': 30}, "'frame_rate' is 30; it must be a number with a point"),
        ('camera', {'camera_info_url': '/no.yaml'}, 'cannot read the calibration /no.yaml'),
        ('camera', {'camera_info_url': 'http://x/y'}, "'camera_info_url': http://x/y: write"),
        ('camera', {'pixel_format': 'RGB9'}, "'RGB9'; it must be one of '', GREY"),
        ('segmenter', {'min_snrr': 9.0}, "no parameter 'min_snrr'; did you mean 'min_snr'?"),
        ('segmenter', {'typo': 1}, "no parameter 'typo'; there is image_transport"),
        (
            'segmenter',
            {'qos_overrides./camera/image_raw.subscription.reliability': 'magic'},
            "'qos_overrides./camera/image_raw.subscription.reliability' is 'magic'; it must be ",
        ),
        ('segmenter', {'min_snr': -1.0}, "'min_snr' is -1.0; it must be a number with a point"),
        ('segmenter', {'max_blob': 'big'}, "'max_blob' is 'big'; it must be an integer"),
        ('locator', {'method': 'magic'}, "'method' is 'magic'; it must be one of "),
        ('locator', {'method': 'centroid', 'elliptical': True}, "'centroid' has no such form"),
        ('locator', {'noise__gain': 0.0}, "'noise.gain' is 0.0"),
        ('tracker', {'model': 'magic'}, "'model' is 'magic'; it must be one of constant_vel"),
        ('tracker', {'joints__pan': 'a', 'joints__tilt': 'a'}, "are both 'a'; they must be two"),
        ('tracker', {'imu__enabled': 1}, "'imu.enabled' is 1; it must be a boolean"),
        ('locator', {'looks': 0}, "'looks' is 0; it must be an integer from 1 to 256"),
        ('simulator', {'width': 5}, "'width' is 5; it must be an integer from 16 to 8192 px"),
    ],
)
def test_wrong_parameter_ends_with_a_sentence(
    name: str, parameters: dict[str, object], sentence: str, domain: int
) -> None:
    """Exit code 2, and one sentence with the value and what would be right."""
    with start(name, domain, **parameters) as process:
        assert process.wait(PATIENCE) == 2
    assert sentence in process.output
    assert 'Traceback' not in process.output


@pytest.mark.parametrize('pause', [0.0, 0.2, 0.5, 1.0])
@pytest.mark.parametrize('name', NODES)
def test_ctrl_c_while_loading_leaves_no_trace(name: str, pause: float, domain: int) -> None:
    """In the imports, and in the start of ROS; Python's own start is not the node's."""
    with start(name, domain) as process:
        while process.running and 'numpy' not in process.libraries():
            time.sleep(0.005)
        time.sleep(pause)
        assert process.end(signal.SIGINT) in (0, -signal.SIGINT)
    assert 'Traceback' not in process.output


@pytest.mark.parametrize(
    'name', ['nodes.camera', 'nodes.simulator', 'commands.replay', 'commands.demo']
)
def test_what_fits_nothing_does_not_load_the_compiler(name: str, tmp_path: Path) -> None:
    """Numba takes as long to load as all the rest."""
    code = f'import sys, blob_tracker.{name}; sys.exit("numba" in sys.modules)'
    # From elsewhere: what is installed is meant, not the sources that the tests lie beside.
    assert subprocess.run([sys.executable, '-c', code], cwd=tmp_path).returncode == 0


def test_what_is_seldom_used_is_not_loaded_at_the_start(tmp_path: Path) -> None:
    """Not by any node: SciPy's optimizer takes a second, and 25 MB; each as it is used."""
    code = (
        'import sys, blob_tracker.nodes.pipeline; '
        'sys.exit(any(name in sys.modules for name in '
        '("cv2", "scipy", "xml.etree", "shutil", "matplotlib", '
        '"blob_tracker.simulation", "blob_tracker.capture.v4l2")))'
    )
    assert subprocess.run([sys.executable, '-c', code], cwd=tmp_path).returncode == 0


def test_a_node_starts_no_threads_for_matrices(tmp_path: Path) -> None:
    """There would be one for each core, which takes another node's while it waits for work."""
    code = (
        'import os; from unittest.mock import patch; from blob_tracker.nodes import start; '
        'patch("blob_tracker.ros.process.begin", lambda images: 0).start(); '
        'patch.object(start, "import_module").start(); '
        'of_ros = len(os.listdir("/proc/self/task")); '
        'start.locator(); import numpy; '
        'assert len(os.listdir("/proc/self/task")) == of_ros'
    )
    own = {name: value for name, value in os.environ.items() if name != 'OPENBLAS_NUM_THREADS'}
    assert subprocess.run([sys.executable, '-c', code], cwd=tmp_path, env=own).returncode == 0


@pytest.mark.parametrize('name, words, whole', [
    ('camera', [], True),
    ('segmenter', [], False),
    ('pipeline', [], True),
    ('pipeline', ['-p', 'source:=simulator'], True),
    ('pipeline', ['-p', 'source:=images'], False),
    ('pipeline', ['-p', 'pipeline:source:=images'], False),
    ('pipeline', ['-p', 'other:source:=images'], True),
    ('pipeline', ['-p', 'source:=images', '-p', 'source:=camera'], True),
])
def test_who_publishes_whole_frames(name: str, words: list[str], whole: bool) -> None:
    """And so needs a large segment of shared memory: not who is given the frames of others."""
    assert publishes_images(name, [name, '--ros-args', *words]) == whole


def test_a_missing_parameter_file_ends_with_a_sentence(domain: int) -> None:
    """Without what rcl says of its own source."""
    with start('camera', domain, '--params-file', '/no/such.yaml') as process:
        assert process.wait(PATIENCE) == 2
    assert process.output == (
        "the parameter file '/no/such.yaml' cannot be read: No such file or directory\n"
    )


@pytest.mark.parametrize(('words', 'sentence'), [
    (('-p', 'method'), 'wrong ROS arguments'),
    (('-p', 'method=auto'), '; write -p NAME:=VALUE'),
    (('-r', 'target/ray=ray'), '; write -r OLD:=NEW'),
])
def test_wrong_ros_arguments_end_with_a_sentence(
    words: tuple[str, ...], sentence: str, domain: int
) -> None:
    """With what to write."""
    with start('locator', domain, *words) as process:
        assert process.wait(PATIENCE) == 2
    assert sentence in process.output
    assert 'Traceback' not in process.output
