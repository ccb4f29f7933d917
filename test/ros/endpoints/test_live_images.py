"""Images of a topic as they come, and why none do."""

from __future__ import annotations

from blob_tracker.ros.endpoints import live_images
from blob_tracker.ros.endpoints.live_centroids import LiveCentroids, NoCentroidsError
from blob_tracker.ros.endpoints.live_images import NoImagesError
import pytest
from sensor_msgs.msg import CompressedImage, Image
from support.processes import probe


@pytest.fixture(autouse=True)
def impatience(domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have the command listen in the domain of the test, and not for long."""
    monkeypatch.setenv('ROS_DOMAIN_ID', str(domain))
    for module in ('live_images', 'live_centroids'):
        monkeypatch.setattr(f'blob_tracker.ros.endpoints.{module}.PATIENCE_S', 2.0)


def test_a_publisher_of_another_type_is_named(domain: int) -> None:
    """As the nodes do it, in place of the topics on which there are images."""
    with probe(domain) as node:
        node.create_publisher(CompressedImage, 'camera/image_raw', 1)
        with pytest.raises(NoImagesError, match=(
            '/camera/image_raw: /probe publishes sensor_msgs/msg/CompressedImage there and this '
            'node takes sensor_msgs/msg/Image; remap one of the two'
        )):
            next(live_images.live_images('camera/image_raw'))


def test_so_is_one_of_centroids(domain: int) -> None:
    """In place of a question whether the locator runs."""
    with probe(domain) as node:
        node.create_publisher(Image, 'target/centroid', 1)
        with LiveCentroids('target/centroid') as live, pytest.raises(
            NoCentroidsError, match='/target/centroid: /probe publishes sensor_msgs/msg/Image'
        ):
            live.mean(2)


def test_where_nobody_publishes_the_topics_with_images_are_listed(domain: int) -> None:
    """The name may be another."""
    with probe(domain) as node:
        node.create_publisher(Image, 'left/image_raw', 1)
        with pytest.raises(NoImagesError, match='images are published on /left/image_raw'):
            next(live_images.live_images('camera/image_raw'))
