"""What is lost on the way is counted, and a grave loss has its reason."""

from __future__ import annotations

from types import SimpleNamespace

from blob_tracker.ros.health import Health, WARN
from blob_tracker.ros.lost_messages import LostMessages
from blob_tracker.ros.qos import IMAGE_OUT
from diagnostic_msgs.msg import DiagnosticArray
from processes import probe
from sensor_msgs.msg import Image


def test_a_grave_loss_is_a_warning_with_the_publisher_and_the_reason(domain: int) -> None:
    """Five of fifty: the sentence names who sent them; one alone is only counted."""
    with probe(domain) as node:
        arrays = node.record(DiagnosticArray, '/diagnostics')
        lost = LostMessages(node, 'images', Health(node, 'nothing'))
        node.create_publisher(Image, 'images', IMAGE_OUT)

        def told() -> dict[str, str]:
            values = arrays[-1].status[0].values if arrays else []
            return {each.key: each.value for each in values}

        lost.took(300_000)
        lost.lost(SimpleNamespace(total_count_change=1))
        node.spin_until(lambda: told().get('images lost on the way') == '1')
        assert not any('lost on the way' in each.status[0].message for each in arrays)
        for _ in range(45):
            lost.took(300_000)
        lost.lost(SimpleNamespace(total_count_change=5))
        node.spin_until(lambda: 'lost on the way from /probe: ' in arrays[-1].status[0].message)
        assert told()['images lost on the way'] == '6'
        assert arrays[-1].status[0].level == WARN
