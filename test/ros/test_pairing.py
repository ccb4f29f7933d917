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


def test_stamps_that_jump_back_leave_nothing_of_before() -> None:
    """Neither stays what waited nor goes what came already; whichever topic jumps first."""
    pairs: list[int] = []
    pairing = StampPairing(lambda i, c: pairs.append(to_ns(i.header.stamp)))
    for stamp_ns in range(100, 100 + DEPTH):
        pairing.image(image(stamp_ns))
        pairing.camera_info(stamped(CameraInfo(), stamp_ns + 1000, ''))
    pairing.camera_info(stamped(CameraInfo(), 1, ''))
    assert (pairing.lonely_images, pairing.lonely_infos) == (DEPTH, 1)
    pairing.image(image(1))
    assert pairs == [1]
    assert (pairing.lonely_images, pairing.lonely_infos) == (0, 0)


def test_a_clock_that_jumps_back_takes_what_waits_with_it() -> None:
    """What is later than the time that is given, and nothing else."""
    pairing = StampPairing(lambda i, c: None)
    for stamp_ns in (1, 2, 3):
        pairing.image(image(stamp_ns))
        pairing.camera_info(stamped(CameraInfo(), stamp_ns + 10, ''))
    pairing.forget(2)
    assert (pairing.lonely_images, pairing.lonely_infos) == (2, 0)
