"""Segmenter and locator with a response: alike in one process and in several, and what is said."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from blob_tracker import CameraModel, Frame, Pipeline
from blob_tracker.nodes.locator import LocatorNode
from blob_tracker.nodes.segmenter import SegmenterNode
from blob_tracker.nodes.segmenter.noise_topic import NoiseTopic
from blob_tracker.ros.diagnostics.health import Health
from blob_tracker.ros.endpoints.delivery import Delivery
from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.messages.camera_info import from_camera_model
from blob_tracker.ros.messages.image import to_window
from blob_tracker.types import Bearing, Window
import numpy as np
import pytest
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo
from support.gamma import (
    gamma_response, gamma_scene, HEIGHT, linear_noise, seen, still_scene, WIDTH,
)
from support.window_messages import from_window, of_window

FRAMES = 20


@pytest.fixture(scope='module')
def frames() -> list[Frame]:
    """Return frames of a flashing light in front of a camera with gamma."""
    scene = gamma_scene(200.0, 20.0, moving=True)
    return [Frame(scene.frame(k), scene.stamp_ns(k), 255) for k in range(FRAMES)]


@pytest.fixture
def said(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return what the diagnostics warn of."""
    told: list[str] = []
    monkeypatch.setattr(Health, 'fault', lambda self, level, message: told.append(message))
    return told


class Chain:
    """A segmenter and a locator whose windows go over in memory, or as messages."""

    def __init__(self, *, by_message: bool) -> None:
        self.bearings: list[Bearing] = []
        self.windows: list[Window] = []
        self._by_message = by_message
        self._locator = LocatorNode(
            listen=False, deliver=lambda delivery: self.bearings.append(delivery.item)
        )
        self._segmenter = SegmenterNode(
            listen=False, deliver=self._locate, announce=self._locator.set_lights
        )
        model = CameraModel.from_field_of_view(WIDTH, HEIGHT, 50.0)
        self._info = from_camera_model(model, WIDTH, HEIGHT)

    def _locate(self, delivery: Delivery[tuple[Window, CameraInfo]]) -> None:
        window, info = delivery.item
        if self._by_message:
            part = of_window(info, window, 'optical')
            window, info = to_window(from_window(window, 'optical'), part), part
        self.windows.append(window)
        self._locator.locate(Delivery((window, info), delivery.frame_id, delivery.light))

    def run(self, frames: list[Frame]) -> list[Bearing]:
        """Return the bearings of frames."""
        for frame in frames:
            self._segmenter.segment(Delivery((frame, self._info), 'optical'))
        return self.bearings

    def close(self) -> None:
        """End the nodes."""
        self._segmenter.destroy_node()
        self._locator.destroy_node()


def chain(domain: int, parameters: dict[str, Any], *, by_message: bool = False) -> Iterator[Chain]:
    """Yield a chain of nodes with these parameters."""
    words = ['--ros-args']
    for name, value in parameters.items():
        words += ['-p', f'{name}:={value}']
    rclpy.init(args=words, domain_id=domain)
    try:
        nodes = Chain(by_message=by_message)
        yield nodes
        nodes.close()
    finally:
        rclpy.shutdown()


def with_response(folder: Path, width: int = WIDTH) -> dict[str, Any]:
    """Return the parameters for a camera with gamma."""
    path = folder / 'response.yaml'
    gamma_response(width).to_yaml(path)
    noise = linear_noise()
    return {
        'segmenter:response_url': path, 'locator:response_url': path,
        'locator:noise.gain': noise.gain, 'locator:noise.read_noise': noise.read_noise,
    }


@pytest.mark.parametrize('by_message', [False, True])
def test_the_numbers_are_those_of_the_pipeline(
    by_message: bool, frames: list[Frame], said: list[str], tmp_path: Path, domain: int
) -> None:
    """To the last bit, in one process and in several; and nothing is warned of."""
    model = CameraModel.from_field_of_view(WIDTH, HEIGHT, 50.0)
    right = list(Pipeline(model, noise=linear_noise(), response=gamma_response()).run(frames))
    for nodes in chain(domain, with_response(tmp_path), by_message=by_message):
        found = nodes.run(frames)
        assert [each.azimuth for each in found] == [each.azimuth for each in right]
        assert [each.covariance.tolist() for each in found] == [
            each.covariance.tolist() for each in right
        ]
        assert len(found) >= FRAMES // 2 - 2
    assert not said


def test_a_response_of_another_size_is_told_and_the_rest_goes_on(
    frames: list[Frame], said: list[str], tmp_path: Path, domain: int
) -> None:
    """By both nodes; pixels are taken for linear."""
    for nodes in chain(domain, with_response(tmp_path, 640)):
        assert nodes.run(frames)
        assert nodes.windows[0].lit.dtype == 'uint8'
    sentence = 'response_url: the response is of a camera with 640 x 96 px and the picture has 128'
    assert sum(each.startswith(sentence) for each in said) > FRAMES


def test_a_locator_alone_with_a_response_is_told(
    frames: list[Frame], said: list[str], tmp_path: Path, domain: int
) -> None:
    """Its windows are raw: the segmenter was not given the file."""
    parameters = with_response(tmp_path)
    del parameters['segmenter:response_url']
    for nodes in chain(domain, parameters):
        assert nodes.run(frames)
    assert any('give the segmenter the same response_url' in each for each in said)


@pytest.mark.parametrize('by_message', [False, True])
def test_a_locator_without_the_response_knows_what_is_clipped(
    by_message: bool, said: list[str], tmp_path: Path, domain: int
) -> None:
    """As one that has it: a clipped light is placed alike, and is called no disc."""
    scene = gamma_scene(330.0, 20.0, moving=True)
    clipped = [Frame(scene.frame(k), scene.stamp_ns(k), 255) for k in range(FRAMES)]
    parameters = with_response(tmp_path)
    found = []
    for word in ('locator:response_url', 'none'):
        parameters.pop(word, None)
        parameters['locator:saturation'] = 0
        for nodes in chain(domain, parameters, by_message=by_message):
            nodes.run(clipped)
            assert sum((each.lit == 65535).any() for each in nodes.windows) > FRAMES // 2 - 4
            found.append([each.azimuth for each in nodes.bearings])
    assert found[0] == found[1]
    assert len(found[0]) > FRAMES // 2 - 4
    assert not any('disc' in each for each in said)


def test_a_saturation_of_raw_pixels_is_none_of_linear_ones(
    said: list[str], tmp_path: Path, domain: int
) -> None:
    """Nor does it clip them: a locator that does not know the response says so."""
    frames = [
        Frame(scene.frame(k), scene.stamp_ns(k), 255)
        for scene in (gamma_scene(200.0, 20.0),) for k in range(FRAMES)
    ]
    parameters = {**with_response(tmp_path), 'saturation': 250}
    del parameters['locator:response_url']
    for nodes in chain(domain, parameters):
        assert len(nodes.run(frames)) > FRAMES // 2 - 4
    assert any('and saturation is 250: they are taken for linear' in each for each in said)


@pytest.mark.parametrize('bits', [8, 16])
def test_raw_windows_of_16_bits_are_told_from_linear_ones(
    bits: int, said: list[str], tmp_path: Path, domain: int
) -> None:
    """Where the segmenter has no response, or one of another depth, which both say."""
    scene = gamma_scene(200.0, 20.0, moving=True)
    frames = [
        Frame(scene.frame(k).astype(np.uint16) * 13, scene.stamp_ns(k), 4095)
        for k in range(FRAMES)
    ]
    parameters = {**with_response(tmp_path), 'saturation': 4095}
    if bits == 16:
        eight = gamma_response()
        twelve = replace(eight, levels=np.rint(eight.levels * 4095 / 255), bits=16)
        twelve.to_yaml(tmp_path / 'twelve.yaml')
        parameters['locator:response_url'] = tmp_path / 'twelve.yaml'
    for nodes in chain(domain, parameters):
        assert len(nodes.run(frames)) > FRAMES // 2 - 4
    assert any('for pixels of 8 bits and these have 16' in each for each in said)
    assert any('the windows hold raw pixels' in each for each in said)


def test_a_file_that_is_not_there_ends_the_start(domain: int) -> None:
    """With a sentence: misspelt, it would be a camera without a response."""
    with pytest.raises(ParameterError, match="'response_url': cannot read the response /no.yaml"):
        next(chain(domain, {'response_url': '/no.yaml'}))


def test_a_measured_noise_that_is_that_of_no_linear_sensor(
    said: list[str], domain: int
) -> None:
    """With noise.measure, from whole frames: gamma is named, and no noise is published."""
    random = np.random.default_rng(12)
    light = 6.0 * still_scene(240, 320)
    rclpy.init(domain_id=domain)
    try:
        node = Node('measuring')
        noises = NoiseTopic(node, Health(node, ''))
        noises.enable(True)
        for k in range(4):
            first, second = (seen('rec709', light, random) for _ in range(2))
            frame = Frame(second, 2 * 10**9 * (k + 1), 255)
            noises.measure((first, second), frame, 'optical')
        node.destroy_node()
    finally:
        rclpy.shutdown()
    assert said and said[-1].startswith('noise.measure: the variance of the pixels falls over')
    assert 'set response_url' in said[-1]
