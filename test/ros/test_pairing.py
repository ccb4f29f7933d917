"""Images meet the camera_info of their stamp, whichever comes first."""

from blob_tracker.ros.camera_info import stamped
from blob_tracker.ros.pairing import DEPTH, StampPairing
from blob_tracker.ros.stamp import from_ns, to_ns
from sensor_msgs.msg import CameraInfo, Image


def image(stamp_ns: int) -> Image:
    """Return an image of a stamp."""
    message = Image()
    message.header.stamp = from_ns(stamp_ns)
    return message


def test_pairs_are_delivered_in_either_order() -> None:
    """Nothing is delivered alone or twice."""
    pairs: list[tuple[int, int]] = []
    pairing = StampPairing(
        lambda i, c: pairs.append((to_ns(i.header.stamp), to_ns(c.header.stamp)))
    )
    pairing.image(image(1))
    assert pairs == []
    pairing.camera_info(stamped(CameraInfo(), 1, ''))
    pairing.camera_info(stamped(CameraInfo(), 2, ''))
    pairing.image(image(2))
    pairing.image(image(3))
    pairing.camera_info(stamped(CameraInfo(), 4, ''))
    assert pairs == [(1, 1), (2, 2)]


def test_waiting_messages_do_not_pile_up() -> None:
    """An image stream without camera_info holds the last few and no more."""
    pairing = StampPairing(lambda i, c: None)
    for stamp_ns in range(100):
        pairing.image(image(stamp_ns))
    assert pairing.lonely_images == DEPTH
    pairing.image(image(200))
    pairing.camera_info(stamped(CameraInfo(), 200, ''))
    assert pairing.lonely_images == 0  # a pair came: the older ones are given up
