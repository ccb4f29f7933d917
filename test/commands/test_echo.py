"""Bearings are printed with their units, and a warning of a node once."""

from __future__ import annotations

import sys

from blob_tracker.commands.echo import advice, Echo, in_words, RAY
from blob_tracker.ros.endpoints.qos import RESULT
from blob_tracker.ros.messages.target import ray_message
from blob_tracker.types import Bearing
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped, Vector3Stamped
import numpy as np
import pytest
from support.processes import probe, Process

ECHO = [sys.executable, '-m', 'blob_tracker', 'echo']
BEARING = Bearing(12.5, -3.25, np.diag([4e-4, 1e-4]), 1_795_314_196_007_000_000)
LINE = (
    '1795314196.007000000 s: azimuth +12.5000 +- 0.0200 mrad, elevation -3.2500 +- 0.0100 mrad'
)


def test_a_bearing_in_words() -> None:
    """The nanoseconds keep their zeros; sigmas are the roots of the covariance."""
    assert in_words(BEARING) == LINE


def warning(reason: str) -> DiagnosticArray:
    """Return what a segmenter says; all is well without a reason."""
    level = DiagnosticStatus.WARN if reason else DiagnosticStatus.OK
    return DiagnosticArray(
        status=[DiagnosticStatus(level=level, name='/segmenter: tracking', message=reason)]
    )


def test_a_warning_is_printed_once(capsys: pytest.CaptureFixture[str]) -> None:
    """As long as it stays the same; again once it has come back."""
    echo = Echo()
    for reason in ('dark', 'dark', '', 'dark', 'clipped'):
        echo.warn(warning(reason))
    assert capsys.readouterr().err.split('\n') == [
        '/segmenter: dark', '/segmenter: dark', '/segmenter: clipped', '',
    ]


def test_bearings_are_printed_until_ctrl_c(domain: int) -> None:
    """Of the topic that is asked for, with their frame."""
    with probe(domain) as node, Process([*ECHO, 'target/port/ray'], domain) as echo:
        rays = node.create_publisher(PoseWithCovarianceStamped, 'target/port/ray', RESULT)
        news = node.create_publisher(DiagnosticArray, '/diagnostics', RESULT)
        node.spin_until(lambda: rays.get_subscription_count() and news.get_subscription_count())
        rays.publish(ray_message(BEARING, 'left_optical'))
        news.publish(warning('dark'))
        rays.wait_for_all_acked()
        news.wait_for_all_acked()
        node.settle(0.5)  # until they are printed
        assert echo.end() == 0
    assert f'{LINE}, in left_optical\n' in echo.output
    assert '/segmenter: dark\n' in echo.output


def test_silence_is_a_failure(domain: int) -> None:
    """After so many seconds without a bearing."""
    with Process([*ECHO, '--seconds', '0.1'], domain) as echo:
        assert echo.wait() == 1
    assert 'no bearing came on target/ray' in echo.output


@pytest.mark.parametrize(('wanted', 'topics', 'said'), [
    ('/target/bearing', {'/target/ray': [RAY], '/target/bearing': ['geometry_msgs/msg/V']},
     f': it has geometry_msgs/msg/V, and this takes rays, {RAY}; there is /target/ray'),
    ('/target/rays', {'/port/ray': [RAY], '/a': [RAY]}, '; there is /a, /port/ray'),
    ('/target/ray', {'/target/ray': [RAY]}, '; the locator runs'),
    ('/target/ray', {'/target/ray': []}, '; there is no topic of rays: does'),
])
def test_what_there_is(wanted: str, topics: dict[str, list[str]], said: str) -> None:
    """By what other nodes publish; this one subscribes to what it was asked for."""
    assert advice(wanted, topics).startswith(said)


def test_what_it_wants_is_said_while_it_waits(domain: int) -> None:
    """A topic of another type has none of the messages that it takes."""
    with probe(domain) as node, Process([*ECHO, 'target/bearing'], domain) as echo:
        node.create_publisher(PoseWithCovarianceStamped, 'target/ray', RESULT)
        node.create_publisher(Vector3Stamped, 'target/bearing', RESULT)
        node.spin_until(lambda: node.count_subscribers('target/bearing'))
        node.settle(2.5)
        assert echo.end() == 1
    assert (
        'no bearing on target/bearing so far: it has geometry_msgs/msg/Vector3Stamped, and this '
        f'takes rays, {RAY}; there is /target/ray\n'
    ) in echo.output
