"""Images that `image_transport republish` compresses lead to bearings."""

from __future__ import annotations

from blob_tracker.nodes.interface import interface_of
from geometry_msgs.msg import Vector3Stamped
import pytest
from support.clients import needs
from support.processes import probe, Process, start

needs('image_transport', 'compressed_image_transport', 'ros2run')

REPUBLISH = [
    'ros2', 'run', 'image_transport', 'republish', '--ros-args',
    '-p', 'in_transport:=raw', '-p', 'out_transport:=compressed',
    '-r', 'in:=/camera/image_raw', '-r', 'out/compressed:=/camera/image_raw/compressed',
]


@pytest.mark.skipif(
    all(each.name != 'image_transport' for each in interface_of('segmenter').parameters),
    reason='the segmenter takes raw images alone',
)
def test_compressed_images_are_located(domain: int) -> None:
    """The segmenter takes them where image_transport says so."""
    with probe(domain) as node:
        bearings = node.record(Vector3Stamped, 'target/bearing')
        with (
            start('segmenter', domain, image_transport='compressed') as segmenter,
            start('locator', domain), start('simulator', domain),
            Process(REPUBLISH, domain) as republish,
        ):
            node.spin_until(lambda: len(bearings) >= 10, 60.0)
            republish.ctrl_c()
    assert 'Traceback' not in segmenter.output
