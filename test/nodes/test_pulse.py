"""What the locator makes of pulse_url and pulse.learn; it places the light in any case."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from blob_tracker.calibration.pulse_file import PulseFile
from blob_tracker.camera import CameraModel
from blob_tracker.location import EffectivePsf, Learned
from blob_tracker.nodes.locator import _new_file
from blob_tracker.ros.endpoints.qos import IMAGE_OUT
from blob_tracker.ros.messages.camera_info import from_camera_model
from blob_tracker.ros.parameters.rooms import pulse_of
from blob_tracker.types import SensorNoise, Window
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PointStamped
import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo, Image
from support.processes import Probe, probe, start
from support.pulses import BACKGROUND, drawn, NOISE, PEAK, shots
from support.window_messages import from_window, of_window

METHOD = 'maximum_likelihood'
WIDTH, HEIGHT = 320, 240
SIDE = 9
SHARP = drawn(SIDE, lambda u, v: (1.0 + (u**2 + v**2) / 1.04**2) ** -2.5, 0.0)


def write(path: Path, sigma: float = 1.5, width: int = WIDTH) -> Path:
    """Write a file with a pulse."""
    bell = np.exp(-0.5 * (np.arange(-12, 13) * 0.5 / sigma) ** 2)
    pulse = EffectivePsf(np.outer(bell, bell) * 1.05, 0.5, sigma)
    learned = Learned(pulse, 300, 0.02, 1.0, 1.0, SensorNoise(10.0, 1.0))
    PulseFile(learned, width, HEIGHT, '850 nm').to_yaml(path)
    return path


class Target:
    """A sharp light that flies through all sub-pixel phases; a flash at each `send`."""

    def __init__(self, node: Probe) -> None:
        self._images = node.create_publisher(Image, 'target/window/image_raw', IMAGE_OUT)
        self._infos = node.create_publisher(CameraInfo, 'target/window/camera_info', IMAGE_OUT)
        self._info = from_camera_model(
            CameraModel.from_field_of_view(WIDTH, HEIGHT, 40.0), WIDTH, HEIGHT
        )
        self._random = np.random.default_rng(1)
        self._window = Window(np.zeros((SIDE, SIDE), np.uint8), stamp_ns=10**18)
        self.node = node

    def send(self) -> None:
        """Publish a flash with a stamp of its own."""
        place = self._random.uniform(100.0, 120.0, 2)
        corner = np.rint(place).astype(int) - SIDE // 2
        mean = BACKGROUND + PEAK * SHARP(*(place - corner))
        lit, unlit = (
            shots(self._random, each).astype(np.uint8)
            for each in (mean, np.full(mean.shape, BACKGROUND))
        )
        self._window = replace(
            self._window, lit=lit, unlit=unlit, x0=int(corner[0]), y0=int(corner[1]),
            stamp_ns=self._window.stamp_ns + 10**7,
        )
        self._images.publish(from_window(self._window, 'optical'))
        self._infos.publish(of_window(self._info, self._window, 'optical'))

    def says(self, sentence: str) -> bool:
        """Tell whether the locator's last diagnostics say so."""
        last = self.node.received['/diagnostics'][-1:]
        return any(sentence in each.status[0].message for each in last)


def test_a_file_is_a_pulse(tmp_path: Path) -> None:
    """By path or URL; an empty parameter is none, and no fault."""
    written = write(tmp_path / 'pulse.yaml')
    for url in (str(written), f'file://{written}'):
        pulse, reason = pulse_of(url, METHOD)
        assert pulse is not None and not reason
    assert pulse_of('', METHOD) == (None, '')


def test_only_a_file_that_is_not_there_yet_is_written(tmp_path: Path) -> None:
    """What somebody has calibrated stays as it is."""
    assert _new_file(str(tmp_path / 'new' / 'pulse.yaml')) == tmp_path / 'new' / 'pulse.yaml'
    for url in (str(write(tmp_path / 'pulse.yaml')), str(tmp_path), '', 'http://x/y'):
        assert _new_file(url) is None


@pytest.mark.parametrize(
    ('url', 'method', 'sentence'),
    [
        ('/no.yaml', METHOD, 'cannot read the learned pulse /no.yaml'),
        ('http://x/y', METHOD, 'http://x/y: write'),
        (None, 'centroid', "the method 'centroid' takes no learned pulse"),
    ],
)
def test_what_cannot_be_used_is_a_sentence(
    tmp_path: Path, url: str | None, method: str, sentence: str
) -> None:
    """The node goes on without it."""
    pulse, reason = pulse_of(url or str(write(tmp_path / 'pulse.yaml')), method)
    assert pulse is None
    assert sentence in reason


def test_with_a_wrong_file_the_gaussian_goes_on_and_says_why(tmp_path: Path, domain: int) -> None:
    """One of another camera, of another size, from too few phases, empty, or none at all."""
    (tmp_path / 'empty.yaml').write_text('')
    few = write(tmp_path / 'few.yaml')
    few.write_text(few.read_text().replace('gap: 0.02', 'gap: 0.4'))
    wrong = {
        write(tmp_path / 'camera.yaml', width=640): 'a camera with 640 x 240 px and the picture',
        write(tmp_path / 'size.yaml', sigma=4.0): 'the learned pulse does not fit, and the',
        few: 'leave 0.40 px of the pixel empty',
        tmp_path / 'empty.yaml': 'holds no named values',
        tmp_path / 'missing.yaml': 'cannot read the learned pulse',
    }
    with probe(domain) as node:
        centroids = node.record(PointStamped, 'target/centroid')
        node.record(DiagnosticArray, '/diagnostics')
        target = Target(node)
        noise = {'noise__gain': NOISE.gain, 'noise__read_noise': NOISE.read_noise}
        with start('locator', domain, **noise):
            node.spin_until(lambda: centroids or target.send())
            for path, sentence in wrong.items():
                assert node.set_parameter('locator', 'pulse_url', str(path)).successful
                centroids.clear()
                node.spin_until(lambda: target.send() or centroids and target.says(sentence))


def test_a_pulse_is_learned_used_and_kept(tmp_path: Path, domain: int) -> None:
    """In the file that pulse_url names."""
    path = tmp_path / 'new' / 'pulse.yaml'
    with probe(domain) as node:
        node.record(PointStamped, 'target/centroid')  # the next flash waits for no longer
        target = Target(node)
        with start(
            'locator', domain, pulse__learn=True, pulse_url=str(path), noise__gain=NOISE.gain,
            noise__read_noise=NOISE.read_noise,
        ):
            node.spin_until(lambda: path.exists() or target.send(), 60.0)
    file = PulseFile.from_yaml(path)
    assert (file.width, file.height) == (WIDTH, HEIGHT)
    assert file.learned.gain > 1.0
    # Half-way out it has the wings that the light has.
    middle = SHARP(4.0, 4.0)
    assert file.learned.pulse.value(1.0, 0.0) == pytest.approx(
        middle[4, 5] / middle[4, 4], abs=0.03
    )
