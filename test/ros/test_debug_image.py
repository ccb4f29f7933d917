"""The picture is drawn while somebody looks, and not too often."""

from __future__ import annotations

from blob_tracker.ros import debug_image
from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.look import Look
import numpy as np
from processes import probe
import pytest
from sensor_msgs.msg import Image


@pytest.mark.parametrize('found, most', [(True, 10), (False, 4)])
def test_pictures_come_only_while_somebody_subscribes(
    found: bool, most: int, domain: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing is drawn before and after; at most ten a second meanwhile."""
    drawn = []
    draw = debug_image.draw
    monkeypatch.setattr(debug_image, 'draw', lambda look: drawn.append(look) or draw(look))
    look = Look(
        np.zeros((120, 160), np.uint8), None, 0.0, 1.0, Box(0, 0, 160, 120), (),
        {'': Box(10, 10, 20, 20)} if found else {}, 'lost', '' if found else 'nothing lit up',
    )
    with probe(domain) as node:
        topic = debug_image.DebugImage(node)
        topic.offer(look, 1, 'optical')
        assert not drawn
        pictures: list[Image] = []
        subscription = node.create_subscription(
            Image, '/probe/debug_image', pictures.append, 10
        )
        node.spin_until(lambda: topic.offer(look, 5, 'optical') or len(pictures) >= 2)
        drawn.clear()
        clock = node.get_clock()
        began = clock.now()
        while (seconds := (clock.now() - began).nanoseconds / 1e9) < 1.0:
            topic.offer(look, 5, 'optical')
        assert 1 <= len(drawn) <= most * seconds + 1
        node.destroy_subscription(subscription)
        node.spin_until(lambda: not node.count_subscribers('/probe/debug_image'))
        drawn.clear()
        topic.offer(look, 6, 'optical')
        node.spin(0.35)
        topic.offer(look, 7, 'optical')
        assert not drawn
    picture = pictures[0]
    assert (picture.encoding, picture.header.frame_id) == ('bgr8', 'optical')
    assert len(picture.data) == picture.step * picture.height
    assert picture.step == 3 * picture.width
