"""The picture is drawn while somebody looks, and not too often."""

from __future__ import annotations

from blob_tracker.ros.endpoints.debug_image import DebugImage
import numpy as np
from numpy.typing import NDArray
import pytest
from sensor_msgs.msg import Image
from support.processes import probe


@pytest.mark.parametrize('pause', [0.1, 0.3])
def test_pictures_come_only_while_somebody_subscribes(pause: float, domain: int) -> None:
    """Nothing is drawn before and after; one in each pause meanwhile."""
    drawn = []

    def draw() -> NDArray[np.uint8]:
        drawn.append(True)
        return np.full((12, 16, 3), (1, 2, 3), np.uint8)

    with probe(domain) as node:
        topic = DebugImage(node)
        topic.offer(draw, 1, 'optical', pause)
        assert not drawn
        pictures: list[Image] = []
        subscription = node.create_subscription(
            Image, '/probe/debug_image', pictures.append, 10
        )
        node.spin_until(lambda: topic.offer(draw, 5, 'optical', pause) or len(pictures) >= 2)
        drawn.clear()
        clock = node.get_clock()
        began = clock.now()
        while (seconds := (clock.now() - began).nanoseconds / 1e9) < 1.0:
            topic.offer(draw, 5, 'optical', pause)
        assert 1 <= len(drawn) <= seconds / pause + 1
        node.destroy_subscription(subscription)
        node.spin_until(lambda: not node.count_subscribers('/probe/debug_image'))
        drawn.clear()
        topic.offer(draw, 6, 'optical', pause)
        node.spin(pause + 0.05)
        topic.offer(draw, 7, 'optical', pause)
        assert not drawn
    picture = pictures[0]
    assert (picture.encoding, picture.header.frame_id) == ('bgr8', 'optical')
    assert (picture.height, picture.width, picture.step) == (12, 16, 48)
    assert picture.data[:3].tolist() == [1, 2, 3]
