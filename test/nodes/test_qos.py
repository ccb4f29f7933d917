"""Real nodes name who does not fit at the other end of a topic, and why frames are lost."""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.resources import config_path
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Vector3Stamped
import pytest
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from support.processes import Probe, probe, start

BEST_EFFORT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
PROFILE = 'FASTRTPS_DEFAULT_PROFILES_FILE'


def says(node: Probe, name: str) -> Callable[[str], bool]:
    """Return what tells whether the last diagnostics of a node warn of something."""

    def said(sentence: str) -> bool:
        last = [
            array.status[0] for array in node.received['/diagnostics']
            if array.status[0].name == f'/{name}: tracking'
        ][-1:]
        return any(
            each.level == DiagnosticStatus.WARN and sentence in each.message for each in last
        )

    return said


def test_ends_that_do_not_fit_are_named(domain: int) -> None:
    """Inputs and outputs: quality of service, type, and two publishers; and it ends with them."""
    # Two participants: one knows a topic by one type only.
    with probe(domain) as node, probe(domain) as second:
        node.record(DiagnosticArray, '/diagnostics')
        segmenter, locator = says(node, 'segmenter'), says(node, 'locator')
        driver = Node('driver', context=node.context)
        other = Node('other', context=second.context)
        # Images of one node with the camera_info of another are as they should be.
        images = driver.create_publisher(Image, 'camera/image_raw', BEST_EFFORT)
        other.create_publisher(CameraInfo, 'camera/camera_info', 1)
        other.create_publisher(Vector3Stamped, 'target/noise', 1)
        other.create_subscription(Vector3Stamped, 'target/bearing', print, LATCHED)
        reliable = 'qos_overrides./camera/image_raw.subscription.reliability'
        latched = 'qos_overrides./target/centroid.publisher.durability'
        with (
            start('segmenter', domain, **{reliable: 'reliable'}) as process,
            start('locator', domain, noise__online=True, **{latched: 'transient_local'}),
        ):
            node.spin_until(lambda: segmenter(
                '/camera/image_raw: /driver publishes best_effort and this node asks for '
                'reliable, so that nothing arrives from it; set its reliability to reliable, or '
                f'{reliable} of this node to best_effort'
            ))
            node.spin_until(lambda: locator(
                '/target/noise: /other publishes volatile and this node asks for transient_local'
            ))
            assert locator(
                '/target/bearing: /other asks for transient_local and this node publishes '
                'volatile, so that it hears nothing; set its durability to volatile, or '
                'qos_overrides./target/bearing.publisher.durability of this node to '
                'transient_local'
            )
            assert not segmenter(' nodes publish /camera')
            # The override of an output is in effect: who asks for what it offers is served.
            other.create_subscription(Vector3Stamped, 'target/centroid', print, LATCHED)
            centroids = node.get_publishers_info_by_topic('target/centroid')
            assert [each.qos_profile.durability for each in centroids] == [
                DurabilityPolicy.TRANSIENT_LOCAL
            ]
            other.create_publisher(CompressedImage, 'camera/image_raw', 1)
            node.spin_until(lambda: segmenter(
                '/camera/image_raw: /other publishes sensor_msgs/msg/CompressedImage there and '
                'this node takes sensor_msgs/msg/Image; remap one of the two'
            ) and segmenter(
                '2 nodes publish /camera/image_raw: /driver, /other; stop all but one'
            ))
            driver.destroy_publisher(images)
            node.spin_until(lambda: not segmenter('/driver'))
            assert segmenter('/other publishes sensor_msgs/msg/CompressedImage')
        driver.destroy_node()
        other.destroy_node()
    assert '[segmenter]: /camera/image_raw: /driver publishes best_effort' in process.output


@pytest.mark.parametrize('parameter, value', [
    ('qos_overrides./target/bearing.publisher.depth', 'deep'),
    ('qos_overrides./target/window/image_raw.subscription.durability', 'for ever'),
])
def test_an_impossible_override_ends_the_node(parameter: str, value: str, domain: int) -> None:
    """Exit code 2 and a sentence with its name."""
    with start('locator', domain, **{parameter: value}) as process:
        assert process.wait() == 2
    assert f"parameter '{parameter}' is '{value}'; it must be " in process.output
    assert 'Traceback' not in process.output


def test_frames_lost_for_want_of_the_profile(
    domain: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Images that do not fit into Fast DDS' own 512 KiB: the line to type, for whom, and why."""
    with probe(domain) as node:
        node.record(DiagnosticArray, '/diagnostics')
        segmenter = says(node, 'segmenter')
        with start('segmenter', domain) as process:
            monkeypatch.delenv(PROFILE)
            with start('simulator', domain, width=1920, height=1200, rate=20.0):
                node.spin_until(lambda: segmenter(
                    'lost on the way from /simulator: its shared memory has 536 KiB, and an image '
                    '2250; a Fast DDS profile gives it more, unless it is dropped for a fault in '
                    'it, see doctor: in its terminal, before it starts, type: export '
                    f'{PROFILE}={config_path("fastdds.xml")}'
                ), 40.0)
    assert f'type: export {PROFILE}={config_path("fastdds.xml")}' in process.output
