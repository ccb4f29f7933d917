"""What rqt shows: images of the topics, and the diagnostics of the nodes."""

from __future__ import annotations

from importlib import import_module

from diagnostic_msgs.msg import DiagnosticArray
import pytest
from sensor_msgs.msg import Image
from support.clients import needs
from support.processes import probe, Process, start

needs('cv_bridge', 'diagnostic_aggregator', 'rqt_gui', 'rqt_image_view')


@pytest.mark.parametrize('topic', [
    'camera/image_raw', 'segmenter/debug_image', 'locator/debug_image',
])
def test_its_converter_takes_the_images(topic: str, domain: int) -> None:
    """To three colours, as its view asks for them."""
    bridge = import_module('cv_bridge').CvBridge()
    with probe(domain) as node:
        images = node.record(Image, topic)
        with start('simulator', domain), start('segmenter', domain), start('locator', domain):
            node.spin_until(lambda: images)
    shown = bridge.imgmsg_to_cv2(images[0], 'rgb8')
    assert shown.shape == (images[0].height, images[0].width, 3)


def test_its_view_subscribes(domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A topic that is given, on a screen that is not there."""
    monkeypatch.setenv('QT_QPA_PLATFORM', 'offscreen')
    command = ['rqt', '-s', 'rqt_image_view', '--args', '/camera/image_raw']
    with probe(domain) as node, start('simulator', domain), Process(command, domain) as rqt:
        node.spin_until(lambda: node.count_subscribers('/camera/image_raw'), 60.0)
        rqt.ctrl_c(20.0)


def test_the_aggregator_has_the_nodes(domain: int) -> None:
    """Under their names, which the monitor of robots shows as a tree."""
    command = ['ros2', 'run', 'diagnostic_aggregator', 'aggregator_node']
    with probe(domain) as node:
        arrays = node.record(DiagnosticArray, '/diagnostics_agg')
        with start('segmenter', domain), Process(command, domain) as aggregator:
            node.spin_until(lambda: any(
                'segmenter: tracking' in status.name
                for array in arrays for status in array.status
            ), 40.0)
            aggregator.ctrl_c()
