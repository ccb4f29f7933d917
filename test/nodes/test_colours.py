"""Colour messages through segmenter and locator: the light is where it is, by its own samples."""

from __future__ import annotations

import itertools
import time

from blob_tracker.camera import CameraModel
from blob_tracker.ros.endpoints.qos import IMAGE_OUT
from blob_tracker.ros.messages.camera_info import from_camera_model, stamped
from blob_tracker.ros.messages.image import from_frame
from blob_tracker.types import Frame
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PointStamped
import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo, Image
from support.filtered_flashes import BACKGROUND, digitised, gaussian, NOISE, SHAPE, STEP_NS
from support.processes import PATIENCE, Probe, probe, start
from support.slowness import slowness

MODEL = CameraModel.from_field_of_view(SHAPE[1], SHAPE[0], 40.0)
PLACE = 44.3, 34.7
RED = np.tile([[1.0, 0.08], [0.08, 0.02]], (SHAPE[0] // 2, SHAPE[1] // 2))  # RGGB


def play(node: Probe, layout: str, until) -> None:
    """Publish the frames of a red light that flashes, until something has come of them."""
    random = np.random.default_rng(4)
    images = node.create_publisher(Image, 'camera/image_raw', IMAGE_OUT)
    infos = node.create_publisher(CameraInfo, 'camera/camera_info', IMAGE_OUT)
    began = time.monotonic()
    for index in itertools.count():
        light = 100.0 * gaussian(*PLACE, 1.5) * (index % 2)
        if layout == 'grey':
            pixels = digitised(BACKGROUND + light, random)
        else:
            pixels = digitised(BACKGROUND + RED * light, random)
        frame = Frame(pixels, 10**18 + index * STEP_NS, 255, layout=layout)
        infos.publish(stamped(
            from_camera_model(MODEL, SHAPE[1], SHAPE[0]), frame.stamp_ns, 'optical'))
        images.publish(from_frame(frame, 'optical'))
        node.spin(0.01)
        if until():
            break
        assert time.monotonic() - began < PATIENCE * slowness()


def test_a_red_light_on_a_bayer_camera(domain: int) -> None:
    """Segmenter and locator agree on which pixels see it, by a message alone."""
    with probe(domain) as node:
        windows = node.record(Image, 'target/window/image_raw')
        centroids = node.record(PointStamped, 'target/centroid')
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        with start('segmenter', domain), start(
            'locator', domain, noise__gain=NOISE.gain, noise__read_noise=NOISE.read_noise
        ):
            play(node, 'rggb', lambda: len(centroids) >= 16 and _channel(diagnostics))
    assert {each.encoding for each in windows} == {'8UC3'}
    assert _channel(diagnostics) == 'red'
    places = np.array([[each.point.x, each.point.y] for each in centroids])
    # The bound is 0.05 px for one of them.
    np.testing.assert_allclose(places.mean(axis=0), PLACE, atol=4 * 0.05 / 4)


@pytest.mark.parametrize(('parameters', 'layout', 'encoding', 'sentence'), [
    ({'channel': 'red'}, 'grey', '', 'the camera is grey, it has no channel red'),
    ({'jpeg_quality': 60}, 'grey', '8UC3', ''),
])
def test_parameters(
    parameters: dict[str, object], layout: str, encoding: str, sentence: str, domain: int
) -> None:
    """What cannot be is said; what a message does not tell is taken from the parameter."""
    with probe(domain) as node:
        windows = node.record(Image, 'target/window/image_raw')
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        with start('segmenter', domain, **parameters):
            play(node, layout, lambda: windows if encoding else any(
                sentence in each.status[0].message for each in diagnostics))
    assert {each.encoding for each in windows} == ({encoding} if encoding else set())


def _channel(diagnostics: list[DiagnosticArray]) -> str:
    """Return the channel that the segmenter says it uses."""
    said = [
        pair.value for each in diagnostics for pair in each.status[0].values
        if pair.key == 'channel'
    ]
    return said[-1] if said else ''
