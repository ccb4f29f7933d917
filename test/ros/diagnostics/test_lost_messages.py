"""What is lost in the queue of a node and what is lost on the way are told apart."""

from __future__ import annotations

from blob_tracker.ros.diagnostics.health import Health, WARN
from blob_tracker.ros.diagnostics.lost_messages import LostMessages
from blob_tracker.ros.endpoints.qos import IMAGE_IN, IMAGE_OUT, subscription
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import Image
from support.processes import Probe, probe


def values(node: Probe) -> dict[str, str]:
    """Return the last values of the diagnostics."""
    arrays = node.received['/diagnostics']
    return {each.key: each.value for each in arrays[-1].status[0].values} if arrays else {}


def test_a_node_that_takes_too_long(domain: int) -> None:
    """Fifty images while it is busy: ten are in the queue, forty were replaced, none was lost."""
    with probe(domain) as node:
        node.record(DiagnosticArray, '/diagnostics')
        health = Health(node, 'nothing')
        lost = LostMessages(node, 'images', health)
        taken: list[Image] = []

        def take(message: Image, information: dict[str, int | None]) -> None:
            taken.append(message)
            lost.took(len(message.data), information)

        subscription(node, Image, 'images', take, IMAGE_IN, lost.lost)
        images = node.create_publisher(Image, 'images', IMAGE_OUT)
        node.spin_until(images.get_subscription_count)
        node.spin_until(lambda: images.publish(Image()) or taken)
        node.settle(0.1)
        before = len(taken)
        for _ in range(50):
            images.publish(Image(data=bytes(100)))
        node.spin_until(lambda: len(taken) >= before + 10)
        images.publish(Image())
        node.spin_until(lambda: 'images not taken in time' in values(node))
        told = values(node)
        status = node.received['/diagnostics'][-1].status[0]
    assert told['images not taken in time'] == '40'
    assert 'images lost on the way' not in told
    assert status.level == WARN
    assert '/images: this node is too slow: 40 of ' in status.message


def test_a_publisher_that_begins_again_loses_nothing(domain: int) -> None:
    """It numbers its images from 1, and some went by before it was known."""
    second = 10**9
    with probe(domain) as node:
        node.record(DiagnosticArray, '/diagnostics')
        lost = LostMessages(node, 'images', Health(node, 'nothing'))
        node.create_publisher(Image, 'images', IMAGE_OUT)
        for number, sent in ((1, 0.0), (2, 0.1), (70, 1.2), (71, 1.3), (5, 1.4), (6, 1.5)):
            lost.took(
                100,
                {
                    'publication_sequence_number': number,
                    'source_timestamp': round(sent * second),
                },
            )
        node.spin_until(lambda: len(node.received['/diagnostics']) >= 3)
        assert 'images not taken in time' not in values(node)


def test_publishers_in_turns_are_told_from_one_that_begins_again(domain: int) -> None:
    """Numbers go back once where a publisher begins again, and time and again where two come."""
    with probe(domain) as node:
        lost = LostMessages(node, 'images', Health(node, 'nothing'))

        def took(number: int, sent: float) -> bool:
            sent_ns = round(sent * 1e9)
            lost.took(
                100, {'publication_sequence_number': number, 'source_timestamp': sent_ns}
            )
            return lost.mixed

        assert not any([took(70, 0.0), took(71, 0.1), took(1, 0.2), took(2, 0.3)])
        assert [took(72, 0.4), took(3, 0.5)] == [False, True]
        # The other one has stopped.
        assert not any(took(4 + index, 1.6 + 0.1 * index) for index in range(5))
