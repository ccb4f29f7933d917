"""Images meet the camera_info of their stamp, whichever comes first."""

from blob_tracker.camera import CameraModel
from blob_tracker.ros.diagnostics.health import Health
from blob_tracker.ros.endpoints.pairing import DEPTH, FramePairs, StampPairing
from blob_tracker.ros.endpoints.qos import IMAGE_OUT
from blob_tracker.ros.messages.camera_info import stamped
from blob_tracker.ros.messages.stamp import from_ns, to_ns
from diagnostic_msgs.msg import DiagnosticArray
import pytest
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image
from support.processes import probe


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


def test_the_nearest_stamp_will_do_within_half_an_interval() -> None:
    """Not before the interval is known, and not that of another image."""
    pairs: list[tuple[int, int]] = []
    pairing = StampPairing(
        lambda i, c: pairs.append((to_ns(i.header.stamp), to_ns(c.header.stamp)))
    )
    for stamp_ns in (1000, 2000, 3000):
        pairing.camera_info(stamped(CameraInfo(), stamp_ns + 120, ''))
        pairing.image(image(stamp_ns))
    assert pairs == [(2000, 2120), (3000, 3120)]
    assert pairing.offset_ns == 120
    pairing.image(image(4000))
    pairing.camera_info(stamped(CameraInfo(), 4600, ''))
    assert pairs[2:] == []
    pairing.camera_info(stamped(CameraInfo(), 4700, ''))
    pairing.image(image(5000))
    assert pairs[2:] == [(5000, 4700)]


def test_a_calibration_stands_in_and_steps_back(domain: int) -> None:
    """Without a camera_info, and for one that has none; each image is used once."""
    pairs: list[tuple[int, CameraInfo]] = []
    model = CameraModel.from_field_of_view(96, 72, 40.0)
    with probe(domain) as node:
        frames = FramePairs(
            node, 'camera', Health(node, 'nothing'),
            lambda i, c: pairs.append((to_ns(i.header.stamp), c)),
        )
        frames.stand_in = model
        images = node.create_publisher(Image, 'camera/image_raw', IMAGE_OUT)
        stamps = iter(range(10**9, 10**12, 10**7))

        def publish() -> int:
            stamp_ns = next(stamps)
            images.publish(image(stamp_ns))
            node.spin(0.02)
            return stamp_ns

        node.spin_until(lambda: publish() and pairs)
        assert pairs[-1][1].k[0] == pytest.approx(model.matrix[0, 0])
        infos = node.create_publisher(CameraInfo, 'camera/camera_info', IMAGE_OUT)
        own = CameraInfo(width=96, height=72, binning_x=2)

        def publish_both() -> None:
            infos.publish(stamped(own, publish(), ''))
            node.spin(0.02)

        node.spin_until(lambda: publish_both() or pairs[-1][1].binning_x == own.binning_x)
        own.k[0] = 7.0
        node.spin_until(lambda: publish_both() or pairs[-1][1].k[0] == 7.0)
        used = [stamp_ns for stamp_ns, _ in pairs]
        assert used == sorted(set(used))


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


def test_windows_take_their_own_camera_info_alone() -> None:
    """That of the next window is of another place: a wrong bearing with a small sigma."""
    pairs: list[tuple[int, int]] = []
    pairing = StampPairing(
        lambda i, c: pairs.append((to_ns(i.header.stamp), to_ns(c.header.stamp))), exact=True
    )
    for stamp_ns in (1000, 2000, 3000):
        pairing.image(image(stamp_ns))
        pairing.camera_info(stamped(CameraInfo(), stamp_ns + 10 * (stamp_ns == 3000), ''))
    assert pairs == [(1000, 1000), (2000, 2000)]


@pytest.mark.parametrize('kind, topic', [
    (Image, 'camera/image_raw'), (CameraInfo, 'camera/camera_info')
])
def test_a_second_camera_that_is_silent_is_noticed(kind: type, topic: str, domain: int) -> None:
    """The numbers of its messages tell nothing; the graph does, in two checks."""
    pairs: list[Image] = []
    with probe(domain) as node:
        node.record(DiagnosticArray, '/diagnostics')
        health = Health(node, 'nothing')
        frames = FramePairs(node, 'camera', health, lambda i, c: pairs.append(i))
        images = node.create_publisher(Image, 'camera/image_raw', IMAGE_OUT)
        infos = node.create_publisher(CameraInfo, 'camera/camera_info', IMAGE_OUT)
        stamps = iter(range(1, 10**9))

        def publish() -> None:
            stamp_ns = next(stamps)
            infos.publish(stamped(CameraInfo(), stamp_ns, ''))
            images.publish(image(stamp_ns))
            node.spin(0.03)

        node.spin_until(lambda: publish() or pairs)
        other = Node('other', context=node.context)
        other.create_publisher(kind, topic, IMAGE_OUT)
        sentence = f'{topic}: several nodes publish it (/other, /probe), and none of the images'

        def said() -> list[str]:
            arrays = node.received['/diagnostics']
            return [each.status[0].message for each in arrays]

        node.spin_until(lambda: publish() or any(sentence in each for each in said()))
        pairs.clear()
        node.received['/diagnostics'].clear()
        node.spin_until(lambda: publish() or len(said()) >= 2)
        assert not pairs
        assert not any('without a' in each for each in said())
        other.destroy_node()
        node.spin_until(lambda: publish() or pairs)
        assert frames is not None
