"""All nodes in one process: the same names, topics and parameters as in processes of their own."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.ros.endpoints.qos import IMAGE_IN
from blob_tracker.ros.messages.stamp import to_ns
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped, Vector3Stamped
import numpy as np
import pytest
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from sensor_msgs.msg import CameraInfo, Image
from support.processes import probe, start

RIGHT = 0.15  # px: ten sigmas of the simulated light, which lies at 0.011 px


def test_it_tracks_and_publishes_pictures_only_while_they_are_wanted(domain: int) -> None:
    """Each bearing has its truth; the first subscriber to the frames and windows gets them."""
    with probe(domain) as node, start('pipeline', domain, source='simulator'):
        bearings = node.record(Vector3Stamped, 'target/bearing')
        rays = node.record(PoseWithCovarianceStamped, 'target/ray')
        centroids = node.record(PointStamped, 'target/centroid')
        truths = node.record(PointStamped, 'simulator/truth/centroid')
        node.spin_until(lambda: len(bearings) >= 30)
        true = {to_ns(each.header.stamp): each.point for each in truths}
        errors = [
            (each.point.x - true[stamp].x, each.point.y - true[stamp].y)
            for each in centroids if (stamp := to_ns(each.header.stamp)) in true
        ]
        assert len(errors) >= 20 and np.abs(errors).max() < RIGHT
        assert to_ns(rays[-1].header.stamp) in true

        images = node.record(Image, 'camera/image_raw', IMAGE_IN)
        infos = node.record(CameraInfo, 'target/window/camera_info', IMAGE_IN)
        node.spin_until(lambda: images and infos)
        assert (images[-1].width, images[-1].height) == (640, 480)
        assert infos[-1].roi.width < 640


def test_its_nodes_are_set_by_their_own_names(domain: int, tmp_path: Path) -> None:
    """One parameter file serves both arrangements; what is set reaches the node that has it."""
    file = tmp_path / 'tracker.yaml'
    file.write_text(
        '/**/pipeline: {ros__parameters: {source: simulator}}\n'
        '/**/simulator: {ros__parameters: {rate: 30.0}}\n'
        '/**/segmenter: {ros__parameters: {min_snr: 9.0}}\n'
    )
    with (
        probe(domain) as node,
        start('pipeline', domain, '--params-file', str(file), saturation=250) as pipeline,
    ):
        bearings = node.record(Vector3Stamped, 'target/bearing')
        node.spin_until(lambda: len(bearings) >= 10)
        first, last = (to_ns(bearings[index].header.stamp) for index in (-9, -1))
        assert (last - first) / 8e9 == pytest.approx(2 / 30, rel=0.3)  # every other frame is lit

        def put(name: str, owner: str, value: object) -> tuple[bool, str]:
            message: ParameterMessage = Parameter(name, value=value).to_parameter_msg()
            result = node.call(
                SetParameters, f'{owner}/set_parameters',
                SetParameters.Request(parameters=[message]),
            ).results[0]
            return result.successful, result.reason

        assert put('method', 'locator', 'centroid') == (True, '')
        assert put('min_snr', 'segmenter', 12.0) == (True, '')
        done, reason = put('source', 'pipeline', 'camera')
        assert not done and 'read-only' in reason
        done, reason = put('elliptical', 'locator', True)
        assert not done and "the method 'centroid' has no such form" in reason
        bearings.clear()
        node.spin_until(lambda: len(bearings) >= 5)
        assert pipeline.running


@pytest.mark.parametrize('parameters, sentence', [
    ({'source': 'nothing'}, "'source' is 'nothing'; it must be one of camera, simulator, images"),
    ({'source': 'simulator', 'min_snrr': 8.0}, "no parameter 'min_snrr'; did you mean 'min_snr'"),
    ({'source': 'images', 'min_snr': 1.0}, "'min_snr' is 1.0; it must be a number"),
])
def test_what_cannot_be_is_said(domain: int, parameters: dict[str, object], sentence: str) -> None:
    """Exit code 2 with a sentence, as for each of the nodes by itself."""
    with start('pipeline', domain, **parameters) as process:
        assert process.wait() == 2
        assert sentence in process.output
