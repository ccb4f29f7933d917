"""The locator takes line jitter off what it publishes, and refuses that of another picture."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.camera.line_jitter import LineJitter
from blob_tracker.ros.stamp import to_ns
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PointStamped
import numpy as np
from processes import probe, start
import pytest

WIDTH, HEIGHT = 320, 240
OFFSET = 0.25  # px


def written(folder: Path, height: int) -> Path:
    """Return a file in which every line has the same offset."""
    path = folder / 'line_jitter.yaml'
    LineJitter(np.full(height, OFFSET), np.zeros(height), 0.0).to_yaml(path)
    return path


def test_the_centroid_is_moved_by_the_offset(tmp_path: Path, domain: int) -> None:
    """A simulated camera without jitter comes out a quarter of a pixel to the left."""
    with probe(domain) as node:
        centroids = node.record(PointStamped, 'target/centroid')
        truths = node.record(PointStamped, 'simulator/truth/centroid')
        with (
            start('segmenter', domain),
            start('locator', domain, line_jitter_url=f'file://{written(tmp_path, HEIGHT)}'),
            start('simulator', domain, width=WIDTH, height=HEIGHT),
        ):
            node.spin_until(lambda: len(centroids) >= 30)
        node.spin(0.5)
    truth = {to_ns(m.header.stamp): m.point.x for m in truths}
    errors = [
        m.point.x - truth[to_ns(m.header.stamp)]
        for m in centroids
        if to_ns(m.header.stamp) in truth
    ]
    assert len(errors) >= 20
    # Each is within 0.05 px; the mean of 20 within a quarter of that.
    assert np.mean(errors) == pytest.approx(-OFFSET, abs=0.0125)


def test_another_height_is_an_error_and_silence(tmp_path: Path, domain: int) -> None:
    """No bearing, and a diagnostic that has both heights."""
    with probe(domain) as node:
        centroids = node.record(PointStamped, 'target/centroid')
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        with (
            start('segmenter', domain),
            start('locator', domain, line_jitter_url=str(written(tmp_path, 480))),
            start('simulator', domain, width=WIDTH, height=HEIGHT),
        ):
            sentence = 'line_jitter_url: the line jitter is for 480 lines and the picture has 240'
            node.spin_until(
                lambda: (DiagnosticStatus.ERROR, sentence)
                in [(a.status[0].level, a.status[0].message) for a in diagnostics]
            )
    assert not centroids


@pytest.mark.parametrize(
    'url, sentence',
    [
        ('/no.yaml', "parameter 'line_jitter_url': cannot read the line jitter /no.yaml"),
        ('http://x/y', "parameter 'line_jitter_url': http://x/y: write"),
    ],
)
def test_a_file_that_cannot_be_read_ends_the_start(url: str, sentence: str, domain: int) -> None:
    """Exit code 2 and a sentence."""
    with start('locator', domain, line_jitter_url=url) as process:
        assert process.wait() == 2
        assert sentence in process.output
