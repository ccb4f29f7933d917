"""The locator takes line jitter off what it publishes, and refuses that of another picture."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from blob_tracker.camera import CameraModel
from blob_tracker.camera.line_jitter import LineJitter
from blob_tracker.ros.endpoints.qos import IMAGE_OUT
from blob_tracker.ros.messages.camera_info import from_camera_model
from blob_tracker.simulation import pixel_integrated_gaussian
from blob_tracker.types import Window
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PointStamped
import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo, Image
from support.processes import Probe, probe, start
from support.window_messages import from_window, of_window

WIDTH, HEIGHT = 320, 240
OFFSET = 0.25  # px


def written(folder: Path, height: int) -> Path:
    """Return a file in which every line has the same offset."""
    path = folder / 'line_jitter.yaml'
    LineJitter(np.full(height, OFFSET), np.zeros(height), 0.0).to_yaml(path)
    return path


class Target:
    """A window with a blob in its middle, sent until the locator hears."""

    def __init__(self, node: Probe) -> None:
        self._images = node.create_publisher(Image, 'target/window/image_raw', IMAGE_OUT)
        self._infos = node.create_publisher(CameraInfo, 'target/window/camera_info', IMAGE_OUT)
        pulse = 20.0 + 150.0 * pixel_integrated_gaussian((11, 11), 5.0, 5.0, 1.5)
        model = CameraModel.from_field_of_view(WIDTH, HEIGHT, 40.0)
        self._window = Window(np.rint(pulse).astype(np.uint8), x0=100, y0=60, stamp_ns=10**18)
        self._info = from_camera_model(model, WIDTH, HEIGHT)

    def send(self) -> None:
        """Publish it with a stamp of its own."""
        self._window = replace(self._window, stamp_ns=self._window.stamp_ns + 10**7)
        info = of_window(self._info, self._window, 'optical')
        self._images.publish(from_window(self._window, 'optical'))
        self._infos.publish(info)


def test_the_centroid_is_moved_by_the_offset(tmp_path: Path, domain: int) -> None:
    """A blob at 105 px is seen there on lines that are shifted by a quarter of a pixel."""
    with probe(domain) as node:
        centroids = node.record(PointStamped, 'target/centroid')
        target = Target(node)
        with start('locator', domain, line_jitter_url=f'file://{written(tmp_path, HEIGHT)}'):
            node.spin_until(lambda: centroids or target.send())
    # The blob is rounded to whole DN: 0.005 px.
    assert centroids[0].point.x == pytest.approx(105.0 - OFFSET, abs=0.005)
    assert centroids[0].point.y == pytest.approx(65.0, abs=0.005)


def test_another_height_is_an_error_and_silence(tmp_path: Path, domain: int) -> None:
    """No bearing, and a diagnostic that has both heights."""
    sentence = 'line_jitter_url: the line jitter is for 480 lines and the picture has 240'
    with probe(domain) as node:
        centroids = node.record(PointStamped, 'target/centroid')
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        target = Target(node)
        with start('locator', domain, line_jitter_url=str(written(tmp_path, 480))):
            node.spin_until(
                lambda: target.send() or (DiagnosticStatus.ERROR, sentence)
                in [(a.status[0].level, a.status[0].message) for a in diagnostics]
            )
    assert not centroids


@pytest.mark.parametrize(
    'url, sentence',
    [
        ('/no.yaml', "parameter 'line_jitter_url': cannot read the line jitter /no.yaml"),
        ('http://x/y', "parameter 'line_jitter_url': http://x/y: write"),
    ],
)
def test_a_file_that_cannot_be_read_ends_the_start(url: str, sentence: str, domain: int) -> None:
    """Exit code 2 and a sentence."""
    with start('locator', domain, line_jitter_url=url) as process:
        assert process.wait() == 2
        assert sentence in process.output
