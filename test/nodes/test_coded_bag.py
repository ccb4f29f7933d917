"""A bag of coded lights that move: three ways to track it, one result, and that is the truth."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from blob_tracker import Pipeline, SensorNoise
from blob_tracker.resources import config_path
from blob_tracker.ros.messages.camera_info import to_camera_model
from blob_tracker.ros.messages.image import to_frame
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.segmentation import flash_by_name, Segmenter
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped, Vector3Stamped
import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from sensor_msgs.msg import CameraInfo, Image
from support.processes import PATIENCE, Probe, probe, start, start_replay

BAG = Path(__file__).parents[1] / 'bags' / 'coded_mcap'
FRAMES = 46
CODES = {'port': '1101000', 'starboard': '1110100'}
BITS_PER_SECOND = 45.0
FLASH: dict[str, Any] = {
    'flash.mode': 'coded',
    'flash.codes': ','.join(f'{name}:{bits}' for name, bits in CODES.items()),
    'flash.bits_per_second': BITS_PER_SECOND,
}
LIGHTS = {'lights': ','.join(CODES)}
REPLAY = ('--params-file', str(config_path('replay.yaml')))
# Nothing is lost in a queue on the topics that have the names of the lights, either.
WINDOWS = [
    f'/target/{name}/window/{end}' for name in CODES for end in ('image_raw', 'camera_info')
]
RESULTS = [f'/target/{name}/{end}' for name in CODES for end in ('bearing', 'centroid', 'ray')]
SENT, PUBLISHED = (
    {f'qos_overrides.{topic}.publisher.history': 'keep_all' for topic in topics}
    for topics in (WINDOWS, RESULTS)
)
TAKEN = {
    f'qos_overrides.{topic}.subscription.{policy}': value
    for topic in WINDOWS
    for policy, value in (('reliability', 'reliable'), ('history', 'keep_all'))
}

Bearings = dict[str, list[tuple[int, float, float]]]  # stamp in ns, azimuth and elevation in mrad


def play(node: Probe, domain: int, *nodes: str) -> None:
    """Play the bag to its end."""
    with start_replay(BAG, domain, '--wait', str(PATIENCE), '--nodes', 'probe', *nodes) as replay:
        node.spin_until(lambda: not replay.running)
        assert replay.wait() == 0, replay.output


def by_pipeline(images: list[Image], infos: list[CameraInfo]) -> Bearings:
    """Return what comes of the frames in Python."""
    segmenter = Segmenter(
        flash=flash_by_name('coded', codes=CODES, bits_per_second=BITS_PER_SECOND)
    )
    pipeline = Pipeline(
        to_camera_model(infos[0]), noise=SensorNoise(40.0, 0.7), segmenter=segmenter
    )
    found: Bearings = {name: [] for name in CODES}
    for name, bearing in pipeline.named(to_frame(*pair) for pair in zip(images, infos)):
        found[name].append((bearing.stamp_ns, bearing.azimuth, bearing.elevation))
    return found


def bearings(node: Probe, expected: Bearings) -> Bearings:
    """Return the bearings that came, once there are as many as expected, and forget them."""
    topics = {name: node.received[f'target/{name}/bearing'] for name in CODES}
    node.spin_until(lambda: all(len(topics[name]) >= len(expected[name]) for name in CODES))
    node.settle(0.3)  # any that should not be there
    found = {
        name: [(to_ns(each.header.stamp), each.vector.x, each.vector.y) for each in messages]
        for name, messages in topics.items()
    }
    for messages in topics.values():
        messages.clear()
    return found


@pytest.fixture(scope='module')
def ways(module_domain: int) -> Iterator[tuple[dict[str, Bearings], dict[str, list[Any]]]]:
    """Track the bag in three ways; give the bearings of each, and the topics of the second."""
    with probe(module_domain) as node:
        images = node.record(Image, 'camera/image_raw')
        infos = node.record(CameraInfo, 'camera/camera_info')
        for name in CODES:
            node.record(Vector3Stamped, f'target/{name}/bearing')
            node.record(PointStamped, f'simulator/truth/{name}/centroid')
            node.record(PointStamped, f'target/{name}/centroid')
            node.record(PoseWithCovarianceStamped, f'target/{name}/ray')
        with start('segmenter', module_domain, *REPLAY, **FLASH, **SENT), start(
            'locator', module_domain, *REPLAY, **LIGHTS, **TAKEN, **PUBLISHED
        ):
            for name in CODES:
                topic = f'target/{name}/window/image_raw'
                node.spin_until(lambda: node.count_subscribers(topic))
            play(node, module_domain, 'segmenter', 'locator')
            node.spin_until(lambda: len(images) == len(infos) == FRAMES)
            python = by_pipeline(images, infos)
            processes = bearings(node, python)
        said = {topic: list(messages) for topic, messages in node.received.items()}
        with start(
            'pipeline', module_domain, *REPLAY, **FLASH, **PUBLISHED, source='images'
        ):
            node.spin_until(lambda: node.count_publishers('target/port/bearing'))
            play(node, module_domain, 'segmenter')
            together = bearings(node, python)
        yield {'Pipeline': python, 'processes': processes, 'one process': together}, said


def test_the_three_agree_to_the_last_bit(ways) -> None:
    """Stamps and angles: `Pipeline`, the nodes with `replay`, and the nodes in one process."""
    first, *others = ways[0].values()
    assert all(len(found) > 15 for found in first.values())
    for other in others:
        assert other == first


def test_each_is_where_its_light_was_at_the_stamp(ways) -> None:
    """Few are named within the first code; from then on all that are lit, to five sigma."""
    said = ways[1]
    for name in CODES:
        truths = said[f'simulator/truth/{name}/centroid']
        knots = np.array([to_ns(each.header.stamp) for each in truths])
        path = CubicSpline(
            (knots - knots[0]) / 1e9, [(each.point.x, each.point.y) for each in truths]
        )
        places = said[f'target/{name}/centroid']
        rays = said[f'target/{name}/ray']
        assert len(places) >= 0.7 * len(truths)
        errors, sigmas = [], []
        for place, ray in zip(places, rays):
            true = path((to_ns(place.header.stamp) - knots[0]) / 1e9)
            errors.append((place.point.x - true[0], place.point.y - true[1]))
            covariance = np.reshape(ray.pose.covariance, (6, 6))
            # Through a lens of 150 px, off the axis by 15 degrees at most.
            sigmas.append(150.0 * np.sqrt(covariance[[4, 3], [4, 3]].max()))
        assert (np.abs(errors).max(axis=1) < 5.0 * np.array(sigmas)).all()
        assert np.median(np.abs(errors)) < 0.05
