"""The noise is measured while the nodes run, and the locator takes it and says what was wrong."""

from __future__ import annotations

from blob_tracker.ros.endpoints.qos import STATE
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Vector3Stamped
import pytest
from support.processes import Probe, probe, start

GAIN, READ_NOISE = 8.0, 1.2


def values(node: Probe, name: str) -> dict[str, str]:
    """Return the last values that a node showed, with its message as ''."""
    found: dict[str, str] = {}
    for array in node.received['/diagnostics']:
        if array.status[0].name == f'/{name}: tracking':
            found = {each.key: each.value for each in array.status[0].values}
            found[''] = array.status[0].message
    return found


def test_measured_noise_reaches_the_locator(domain: int) -> None:
    """Within some seconds it is known to 15 %, and the configured 40 e-/DN are warned of."""
    with probe(domain) as node:
        noises = node.record(Vector3Stamped, 'target/noise', STATE)
        node.record(DiagnosticArray, '/diagnostics')
        with (
            start('segmenter', domain, noise__measure=True),
            start('locator', domain, noise__online=True),
            start(
                'simulator', domain, width=320, height=240, background=80.0, texture=20.0,
                noise__gain=GAIN, noise__read_noise=READ_NOISE,
            ),
        ):
            node.spin_until(lambda: len(noises) >= 4)
            node.spin_until(
                lambda: 'as measured' in values(node, 'locator').get('noise', '')
                and 'which is used; set noise.gain' in values(node, 'locator')['']
            )
        last = noises[-1].vector
        segmenter = values(node, 'segmenter')
    # Four pairs of some 70 tiles tell the gain to 3 or 4 %.
    assert last.x == pytest.approx(GAIN, rel=0.15)
    assert last.y == pytest.approx(READ_NOISE, abs=0.4)
    assert last.z == 0.0 and noises[-1].header.frame_id == 'camera_optical_frame'
    assert segmenter['measured gain'].endswith(' e-/DN')
    assert segmenter['measured read noise'].endswith(' DN')
    assert segmenter['measured black level'] == 'at least 0 DN'


def test_the_locator_names_a_noise_that_is_not_as_configured(domain: int) -> None:
    """By default and on an even wall: 40 e-/DN are configured, the camera has 8."""
    with probe(domain) as node:
        node.record(DiagnosticArray, '/diagnostics')
        with (
            start('segmenter', domain),
            start('locator', domain),
            start(
                'simulator', domain, width=160, height=120, background=60.0, texture=0.0,
                noise__gain=GAIN, noise__read_noise=READ_NOISE,
            ),
        ):
            node.spin_until(
                lambda: 'is used instead. Set noise.gain' in values(node, 'locator').get('', '')
            )
        assert values(node, 'locator')['noise'].startswith('as its windows show it: ')


def test_an_even_wall_is_said_to_be_one(domain: int) -> None:
    """Nothing is published, the diagnostics say why, and the locator keeps its own values."""
    with probe(domain) as node:
        noises = node.record(Vector3Stamped, 'target/noise', STATE)
        node.record(DiagnosticArray, '/diagnostics')
        with (
            start('segmenter', domain, noise__measure=True),
            start('locator', domain, noise__online=True),
            start(
                'simulator', domain, width=320, height=240, background=4.0, texture=0.0,
                noise__gain=100.0, noise__read_noise=1.5,
            ),
        ):
            node.spin_until(
                lambda: values(node, 'segmenter').get('measured gain', '').startswith('unknown: ')
                and values(node, 'locator').get('noise') is not None
            )
        assert not noises
        assert 'none has been measured yet' in values(node, 'locator')['noise']
