"""What the nodes say of themselves while they track, in numbers and in pictures."""

from __future__ import annotations

from statistics import median

from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import Image
from support.processes import probe, start

NODES = ('simulator', 'segmenter', 'locator')
ALL = {'rate (Hz)', 'age p50 (ms)', 'latency p50 (ms)', 'latency p99 (ms)', 'CPU (%)',
       'memory (MB)'}


def test_every_node_has_numbers_and_a_picture(domain: int) -> None:
    """All in one process; the sigmas that the locator states are those that it has."""
    with start(
        'pipeline', domain, source='simulator', width=160, height=120, rate=50.0
    ) as pipeline, probe(domain) as node:
        pictures = {
            name: node.record(Image, f'/{name}/debug_image') for name in NODES
        }
        heard = node.record(DiagnosticArray, '/diagnostics')
        shown: dict[str, dict[str, str]] = {}

        def told() -> bool:
            for message in heard:
                status = message.status[0]
                values = {value.key: value.value for value in status.values}
                shown[status.name.split(':')[0].strip('/')] = values
            # Forty places: the standard error of the ratio is 14 %.
            return int(shown.get('locator', {}).get('bearings', '0')) > 40 and len(sigmas()) >= 3

        def sigmas() -> list[float]:
            return [
                float(value.value) for message in heard for value in message.status[0].values
                if value.key == 'sigma x (px)'
            ]

        node.spin_until(told)
        node.spin_until(lambda: all(pictures.values()))
        assert pipeline.running
    for name in NODES:
        assert ALL <= set(shown[name])
        assert float(shown[name]['rate (Hz)']) > 0.0
        assert 0.0 <= float(shown[name]['latency p50 (ms)']) < 1e3
        picture = pictures[name][-1]
        assert (picture.encoding, picture.header.frame_id) == ('bgr8', 'camera_optical_frame')
    assert shown['segmenter']['flash lock'] in ('locked', 'lost')
    # The simulated light has 150 DN; a pixel is the mean over its area, and noise is added.
    assert 120.0 < float(shown['segmenter']['contrast (DN)']) < 170.0
    locator = shown['locator']
    ratio, error = locator['scatter / sigma'].split(' (')[0].split(' +- ')
    assert abs(float(ratio) - 1.0) < 4.0 * float(error) + 0.005
    # A Gaussian of sigma 2 px and SNR 56: 0.012 px, a third more where the window is smaller.
    assert 0.010 < median(sigmas()) < 0.02
    assert float(locator['chi-square mean']) < 1.3
