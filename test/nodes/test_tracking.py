"""Simulator, segmenter and locator in three processes: every topic, against the truth."""

from __future__ import annotations

from blob_tracker.ros.endpoints.qos import STATE
from blob_tracker.ros.messages.stamp import to_ns
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped, Vector3Stamped
import numpy as np
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Bool
from support.processes import probe, start

BUDGET = 0.05  # px rms, what the thesis wanted
LENS = 200.0  # px
HEALTHY = {
    ('/simulator: tracking', 'publishing'),
    ('/segmenter: tracking', 'target in view'),
    ('/locator: tracking', 'target located'),
}


def test_the_light_is_tracked_within_the_budget(domain: int) -> None:
    """Bearing, centroid, ray, window, visible and diagnostics are all there and right."""
    with probe(domain) as node:
        bearings = node.record(Vector3Stamped, 'target/bearing')
        centroids = node.record(PointStamped, 'target/centroid')
        rays = node.record(PoseWithCovarianceStamped, 'target/ray')
        truths = node.record(PointStamped, 'simulator/truth/centroid')
        true_bearings = node.record(Vector3Stamped, 'simulator/truth/bearing')
        windows = node.record(Image, 'target/window/image_raw')
        infos = node.record(CameraInfo, 'target/window/camera_info')
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        with (
            start('segmenter', domain),
            start('locator', domain),
            start('simulator', domain, width=320, height=240, focal_length=LENS),
        ):
            node.spin_until(lambda: len(bearings) >= 90)
            visible = node.record(Bool, 'target/visible', STATE)  # a late subscriber
            node.spin_until(lambda: visible)
            node.spin_until(
                lambda: {(a.status[0].name, a.status[0].message) for a in diagnostics} >= HEALTHY
            )
        node.settle(0.5)

    truth = {to_ns(m.header.stamp): m for m in truths}
    stamps = [to_ns(m.header.stamp) for m in centroids]
    # No bearing in a frame without light; the truth's ends may have been missed.
    assert {s for s in stamps if min(truth) < s < max(truth)} <= set(truth)
    errors = np.array(
        [
            (m.point.x - truth[to_ns(m.header.stamp)].point.x,
             m.point.y - truth[to_ns(m.header.stamp)].point.y)
            for m in centroids
            if to_ns(m.header.stamp) in truth
        ]
    )
    assert len(errors) >= 80
    assert np.sqrt(np.mean(errors**2)) <= BUDGET

    true_bearing = {to_ns(m.header.stamp): m.vector for m in true_bearings}
    for message in bearings:
        true = true_bearing.get(to_ns(message.header.stamp))
        if true is not None:
            # 0.08 px is 7 sigma; 1 px is at most 1 / LENS rad.
            assert abs(message.vector.x - true.x) < 0.08 / LENS * 1e3
            assert abs(message.vector.y - true.y) < 0.08 / LENS * 1e3

    assert all(np.array(m.pose.covariance)[[21, 28]].min() > 0 for m in rays)
    assert {m.encoding for m in windows} == {'8UC2'}
    # Every bearing has its window's camera_info, but for those before that topic was discovered.
    known = {to_ns(m.header.stamp) for m in infos}
    assert known >= {s for m in bearings if (s := to_ns(m.header.stamp)) >= min(known)}
    assert len(known) >= 80
    assert all(m.roi.width >= 7 and m.roi.x_offset > 0 for m in infos)
    assert visible[0].data is True
