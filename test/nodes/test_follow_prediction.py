"""A segmenter that is told where the light will be: by target/track, and within the pipeline."""

from __future__ import annotations

from math import nan

from blob_tracker.camera import CameraModel
from blob_tracker.nodes.segmenter import node as segmenter_node, SegmenterNode
from blob_tracker.resources import config_path
from blob_tracker.ros.messages.camera_info import from_camera_model, stamped
from blob_tracker.ros.messages.image import from_pixels
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.ros.messages.track import track_message
from blob_tracker.simulation import in_step, Light, Scene
from blob_tracker.tracking import Track
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from nav_msgs.msg import Odometry
import numpy as np
import pytest
import rclpy
from rclpy.qos import QoSProfile
from sensor_msgs.msg import CameraInfo, Image
from support.processes import Probe, probe, start

SCENE = Scene(width=320, height=240, rate=60.0, exposure=0.3)
MODEL = CameraModel.from_field_of_view(320, 240, 40.0)
STEP_NS = 16_666_667
FRAMES = 60
# Nothing is lost in a queue, at either end.
REPLAY = ('--params-file', str(config_path('replay.yaml')))
DEEP = QoSProfile(depth=FRAMES)


def place(index: int) -> tuple[float, float]:
    """Return where the light is, px: after a calm start it leaps by 35 px, now here, now there."""
    if index < 12:
        return 160.0, 120.0
    angle = 2.4 * (index // 2)
    return 160.0 + 35.0 * np.cos(angle), 120.0 + 35.0 * np.sin(angle)


class Played:
    """A camera and a tracker that the test plays."""

    def __init__(self, node: Probe) -> None:
        self.node = node
        self.stamp_ns = 10**18
        self._images = node.create_publisher(Image, 'camera/image_raw', DEEP)
        self._infos = node.create_publisher(CameraInfo, 'camera/camera_info', DEEP)
        self.tracks = node.create_publisher(Odometry, 'target/track', DEEP)
        self.windows = node.record(CameraInfo, 'target/window/camera_info')
        self.diagnostics = node.record(DiagnosticArray, '/diagnostics')
        node.spin_until(lambda: all(
            each.get_subscription_count() for each in (self._images, self._infos, self.tracks)
        ))
        node.spin_until(lambda: node.count_publishers('target/window/camera_info'))
        node.meet('segmenter')

    def film(self, sigma: float | None, least: int = 0, taken_off: int = 0) -> set[int]:
        """
        Send the frames, each after its track of a sigma in mrad; return which had windows.

        Where they come at all, at least so many are waited for. The tracker took so many s off
        the stamps.
        """
        self.stamp_ns += 10**9
        begin_ns = self.stamp_ns
        self.windows.clear()
        for index in range(FRAMES):
            self.stamp_ns = begin_ns + index * STEP_NS
            x, y = place(index)
            if sigma is not None:
                state = np.array([*MODEL.angles(x, y)[:2], 0.0, 0.0])
                # Of the frame before, as the last one of a tracker would be.
                before_ns = self.stamp_ns - STEP_NS - taken_off * 10**9
                track = Track(before_ns, state, sigma**2 * np.eye(4))
                self.tracks.publish(
                    track_message(track, 'optical', 'target', stamp_offset=taken_off))
                self.node.spin(0.005)
            light = Light(x, y, 2.0, 60.0, in_step(60.0))
            shown = Scene(width=320, height=240, rate=60.0, exposure=0.3, target=light)
            info = from_camera_model(MODEL, 320, 240)
            self._images.publish(from_pixels(shown.frame(index), self.stamp_ns, 'optical'))
            self._infos.publish(stamped(info, self.stamp_ns, 'optical'))
            self.node.spin(0.005)
        self.node.spin_until(lambda: len(self.windows) >= least)
        self.node.settle(0.5)  # any more
        found = {
            (to_ns(each.header.stamp) - begin_ns + STEP_NS // 2) // STEP_NS: each.roi
            for each in self.windows
        }
        for index, roi in found.items():
            x, y = place(index)
            assert abs(roi.x_offset + 0.5 * (roi.width - 1) - x) < 1.5
            assert abs(roi.y_offset + 0.5 * (roi.height - 1) - y) < 1.5
        return set(found)


def test_the_track_leads_to_a_light_that_leaps(domain: int) -> None:
    """Beyond the gate: all flashes are found with it, few without or where the track is none."""
    with (
        probe(domain) as node,
        start('segmenter', domain, *REPLAY, follow_prediction=True) as segmenter,
    ):
        played = Played(node)
        # Two may be lost to a track that came after its frame, on a machine that is busy.
        least = FRAMES // 2 - 3
        assert len(played.film(1.0, least)) >= least
        assert len(played.film(1.0, least, 37)) >= least  # a camera that stamps by PTP
        assert len(played.film(nan)) < 0.6 * FRAMES / 2
        node.spin_until(lambda: any(
            each.status[0].level == DiagnosticStatus.ERROR
            and 'target/track: azimuth, elevation (mrad) and their' in each.status[0].message
            for each in played.diagnostics
        ))
        assert segmenter.running
        assert len(played.film(None)) < 0.6 * FRAMES / 2  # of before, and too old
        assert node.set_parameter('segmenter', 'follow_prediction', False).successful
        assert len(played.film(1.0)) < 0.6 * FRAMES / 2


def test_the_pipeline_hands_the_prediction_over_in_memory(domain: int) -> None:
    """Nobody subscribes to target/track; frames are looked at where the light is expected."""
    with (
        probe(domain) as node,
        start('pipeline', domain, source='simulator', follow_prediction=True) as pipeline,
    ):
        diagnostics = node.record(DiagnosticArray, '/diagnostics')

        def shown(key: str) -> int:
            values = [
                int(value.value)
                for each in diagnostics if each.status[0].name.startswith('/segmenter')
                for value in each.status[0].values if value.key == key
            ]
            return values[-1] if values else 0

        # Of 60 frames a second, of which each has one from the first bearing on.
        node.spin_until(lambda: shown('frames with a prediction') > 100)
        assert shown('windows') > 40
        assert node.count_subscribers('target/track') == 0
        assert pipeline.running


def test_the_lens_is_compiled_before_the_first_prediction(
    domain: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not when frames wait for it."""
    done: list[str] = []
    monkeypatch.setattr(segmenter_node, 'compile_lens', lambda: done.append('compiled'))
    for follow, compiled in ((False, []), (True, ['compiled'])):
        rclpy.init(
            args=['--ros-args', '-p', f'follow_prediction:={follow}'], domain_id=domain
        )
        try:
            SegmenterNode(listen=False).destroy_node()
        finally:
            rclpy.shutdown()
        assert done == compiled
