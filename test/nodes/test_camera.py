"""The camera node without a usable camera: it says why, publishes nothing, and lives on."""

from __future__ import annotations

from pathlib import Path

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from processes import probe, start
import pytest
from sensor_msgs.msg import Image


@pytest.mark.parametrize(
    'device, sentence',
    [
        ('/dev/no_such_camera', '/dev/no_such_camera: there is no such device'),
        ('/dev/null', '/dev/null: '),
        (str(Path(__file__)), 'test_camera.py: '),
    ],
)
def test_no_camera_is_a_diagnostic_and_not_the_end(
    device: str, sentence: str, domain: int
) -> None:
    """ERROR with the device's name, again and again, while the node tries again."""
    with probe(domain) as node:
        images = node.record(Image, 'camera/image_raw')
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        with start('camera', domain, device=device) as process:
            node.spin_until(
                lambda: sum(
                    a.status[0].level == DiagnosticStatus.ERROR
                    and sentence in a.status[0].message
                    for a in diagnostics
                )
                >= 2
            )
            assert process.running
    assert not images
    assert process.output.count(sentence) <= 3  # throttled: once in 5 s
    assert 'Traceback' not in process.output
