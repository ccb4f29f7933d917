"""On a rolling shutter what is published has the stamp of the line in which the light lies."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.camera import CameraModel
from blob_tracker.ros.endpoints.qos import IMAGE_OUT
from blob_tracker.ros.messages.camera_info import from_camera_model
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.simulation import pixel_integrated_gaussian
from blob_tracker.types import Window
from geometry_msgs.msg import PointStamped, Vector3Stamped
import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo, Image
from support.processes import probe, start
from support.window_messages import from_window, of_window

LINE = 2e-5  # s
NEAR_NS = 20_000  # ns: a line; that of the first line is milliseconds away


def test_the_pipeline_has_the_line_time_of_the_camera(domain: int) -> None:
    """Handed on in memory: bearings and places have the stamps of the simulator's truth."""
    with probe(domain) as node, start(
        'pipeline', domain, source='simulator', row_time=LINE
    ):
        centroids = node.record(PointStamped, 'target/centroid')
        bearings = node.record(Vector3Stamped, 'target/bearing')
        truths = node.record(PointStamped, 'simulator/truth/centroid')
        node.spin_until(lambda: len(centroids) >= 12 and len(bearings) >= 12)
    true = {to_ns(each.header.stamp): each.point for each in truths}
    assert {to_ns(each.header.stamp) for each in centroids} & {
        to_ns(each.header.stamp) for each in bearings
    }
    matched = 0
    for each in centroids:
        stamp_ns = to_ns(each.header.stamp)
        nearest = min(true, key=lambda other: abs(other - stamp_ns))
        if abs(nearest - stamp_ns) < NEAR_NS:
            matched += 1
            assert abs(each.point.y - true[nearest].y) < 0.15
    assert matched >= 10


def test_the_locator_goes_by_the_line_of_the_place(domain: int) -> None:
    """A window has the stamp of its middle line; the blob lies 1.25 lines below."""
    pulse = 20.0 + 150.0 * pixel_integrated_gaussian((13, 11), 5.0, 7.25, 1.5)
    window = Window(np.rint(pulse).astype(np.uint8), x0=100, y0=60, stamp_ns=10**18)
    info = from_camera_model(CameraModel.from_field_of_view(320, 240, 40.0), 320, 240)
    with probe(domain) as node:
        centroids = node.record(PointStamped, 'target/centroid')
        images = node.create_publisher(Image, 'target/window/image_raw', IMAGE_OUT)
        infos = node.create_publisher(CameraInfo, 'target/window/camera_info', IMAGE_OUT)

        def send() -> None:
            nonlocal window
            window = replace(window, stamp_ns=window.stamp_ns + 10**7)
            images.publish(from_window(window, 'optical'))
            infos.publish(of_window(info, window, 'optical'))

        with start('locator', domain, line_time=LINE):
            node.spin_until(lambda: centroids or send())
    found = centroids[0]
    later_ns = to_ns(found.header.stamp) % 10**7
    assert found.point.y == pytest.approx(67.25, abs=0.005)
    assert later_ns == pytest.approx(1e9 * LINE * 1.25, abs=1e9 * LINE * 0.005)


def test_a_readout_that_a_ride_does_not_know_is_refused(domain: int) -> None:
    """96 ms of it, of which the simulated pan/tilt remembers 50, are a sentence and no crash."""
    with start('simulator', domain, platform='sea', rate=10.0, row_time=2e-4) as simulator:
        assert simulator.wait() == 2
    assert "parameter 'row_time' is 0.0002 s" in simulator.output
    assert 'no longer than 0.05 s' in simulator.output
    assert 'Traceback' not in simulator.output
