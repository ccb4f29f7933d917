"""What a node says of itself in a second."""

from __future__ import annotations

from blob_tracker.ros.health import ERROR, Health, OK, WARN
from diagnostic_msgs.msg import DiagnosticArray
from processes import probe


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


def test_a_flood_of_faults_stays_readable(domain: int) -> None:
    """Only the first kinds of a second are kept."""
    with probe(domain) as node:
        heard = node.record(DiagnosticArray, '/diagnostics')
        health = Health(node, 'nothing')
        for letter in 'abcdefghij':
            health.fault(WARN, letter)
        node.spin_until(lambda: heard)
        assert heard[0].status[0].message == 'a; b; c; d'
