"""What a node says of itself in a second."""

from __future__ import annotations

from collections.abc import Callable
import time
from types import SimpleNamespace

from blob_tracker.ros.diagnostics import health as health_module
from blob_tracker.ros.diagnostics.health import ERROR, Health, OK, WARN
from diagnostic_msgs.msg import DiagnosticArray
import pytest
from rclpy.parameter import Parameter
from support.processes import Probe, probe


def shown(
    node: Probe, heard: list[DiagnosticArray], feed: Callable[[], None] = lambda: None
) -> dict[str, str]:
    """Return the values of the next diagnostics; feed the node until they come."""
    heard.clear()
    while not heard:
        feed()
        node.spin(0.01)
    return {value.key: value.value for value in heard[0].status[0].values}


def test_all_that_is_as_bad_as_the_worst_of_a_second_is_published(domain: int) -> None:
    """The same with other numbers is said once, as it was last; what is less bad is left out."""
    with probe(domain) as node:
        heard = node.record(DiagnosticArray, '/diagnostics')
        health = Health(node, 'nothing')
        health.ok('streaming')
        health.fault(WARN, 'uncalibrated')
        health.fault(ERROR, 'gone after 3 frames')
        health.fault(ERROR, 'no signal')
        health.fault(ERROR, 'gone after 4 frames')
        health.fault(WARN, 'dim')
        node.spin_until(lambda: heard)
        status = heard[0].status[0]
        assert (status.level, status.message) == (ERROR, 'gone after 4 frames; no signal')
        health.ok('streaming')
        node.spin_until(lambda: len(heard) > 1)
        assert (heard[1].status[0].level, heard[1].status[0].message) == (OK, 'streaming')


def test_what_is_counted_with_each_frame_is_shown_with_the_rest(domain: int) -> None:
    """Once there is any, in all that was counted; a word that is said again is said anew."""
    with probe(domain) as node:
        heard = node.record(DiagnosticArray, '/diagnostics')
        health = Health(node, 'nothing')
        frames, _ = health.tally('frames'), health.tally('windows')
        for count in (3, 5):
            frames.count = count
            health.count('images refused')
            for _ in range(2):
                health.ok('target in view')
            values = shown(node, heard)
            assert (values['frames'], 'windows' in values) == (str(count), False)
            assert heard[0].status[0].message == 'target in view'
        assert values['images refused'] == '2'
        assert health.tally('frames') is frames


def test_a_flood_of_faults_stays_readable(domain: int) -> None:
    """Only the first kinds of a second are kept."""
    with probe(domain) as node:
        heard = node.record(DiagnosticArray, '/diagnostics')
        health = Health(node, 'nothing')
        for letter in 'abcdefghij':
            health.fault(WARN, letter)
        node.spin_until(lambda: heard)
        assert heard[0].status[0].message == 'a; b; c; d'


def test_rate_age_and_latency_are_shown(domain: int) -> None:
    """By the clock of the node; what a stamp of another clock would say is not said."""
    with probe(domain) as node:
        heard = node.record(DiagnosticArray, '/diagnostics')
        health = Health(node, 'nothing')

        def feed() -> None:
            now_ns = node.get_clock().now().nanoseconds
            came_ns = time.monotonic_ns()
            health.left(now_ns - 30_000_000)
            time.sleep(0.01)  # it is told of what came after the work on it
            health.arrived(now_ns - 20_000_000, came_ns)

        values = shown(node, heard, feed)
        assert 20.0 < float(values['rate (Hz)']) <= 100.0
        # Half of what this process may be kept waiting for.
        assert 20.0 <= float(values['age p50 (ms)']) < 25.0
        assert 30.0 <= float(values['latency p50 (ms)']) < 35.0
        assert float(values['latency p99 (ms)']) >= float(values['latency p50 (ms)'])
        assert float(values['CPU (%)']) >= 0.0
        assert 20.0 < float(values['memory (MB)']) < 2000.0
        for _ in range(200):
            health.arrived(0)
        values = shown(node, heard)
        assert values['age p50 (ms)'].startswith('unknown: the stamps are of another clock (')
        assert float(values['latency p50 (ms)']) < 35.0
        node.set_parameters([Parameter('use_sim_time', value=True)])
        assert shown(node, heard)['latency p50 (ms)'].startswith('unknown: simulated time')


@pytest.mark.parametrize('slowed', ['', 'the exposure is longer than a frame'])
def test_a_rate_that_falls_is_a_fault_where_it_should_stand(
    slowed: str, domain: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Frames come at a steady rate; windows come when there is a target."""
    monkeypatch.setattr('blob_tracker.ros.diagnostics.health.UsualRate.fell', lambda _, rate: 30.0)
    with probe(domain) as node:
        heard = node.record(DiagnosticArray, '/diagnostics')
        health = Health(node, 'nothing', slowed)
        health.ok('streaming')
        node.spin_until(lambda: heard)
        said = heard[0].status[0].message
        assert said == (
            f'0.0 Hz arrive where 30.0 Hz were usual in the last minute: {slowed}'
            if slowed else 'streaming'
        )


def test_the_log_is_not_flooded(domain: int) -> None:
    """What is fed to a node may make a new sentence of each message."""
    with probe(domain) as node:
        logged: list[str] = []
        node.get_logger = lambda: SimpleNamespace(error=logged.append)
        health = Health(node, 'nothing')
        for index in range(10_000):
            health.fault(ERROR, f'the encoding is {chr(0x4e00 + index)}')
    assert len(logged) == health_module.MOST_LOGGED


def test_nothing_is_missed_while_the_others_start(domain: int) -> None:
    """Not even when something was said meanwhile."""
    with probe(domain) as node:
        heard = node.record(DiagnosticArray, '/diagnostics')
        health = Health(node, 'nothing arrives')
        node.spin_until(lambda: heard)
        health.ok('one')
        node.spin_until(lambda: len(heard) > health_module.PATIENCE)
    assert [each.status[0].message for each in heard] == [
        'waiting', 'one', 'waiting', 'nothing arrives'
    ]


def test_nothing_is_logged_after_a_signal(
    domain: int, capfd: pytest.CaptureFixture[str]
) -> None:
    """What cannot be published on /rosout any more, of which rcl would complain."""
    with probe(domain) as node:
        health = Health(node, 'nothing')
        health.fault(WARN, 'before')
        node.context.try_shutdown()
        health.fault(WARN, 'after')
    said = capfd.readouterr().err
    assert 'before' in said
    assert 'after' not in said and 'rosout' not in said
