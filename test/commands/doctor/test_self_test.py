"""What the doctor makes of its own bearings."""

from __future__ import annotations

from typing import Any

from blob_tracker.commands.doctor.finding import Level
from blob_tracker.commands.doctor.self_test import free_domain, judge, Run
import pytest


@pytest.mark.parametrize(
    'changes, level, words',
    [
        ({}, Level.OK, '60 bearings in 2 s'),
        ({'fault': 'no bearing came within 20 s'}, Level.ERROR, 'no bearing came'),
        ({'rms': 0.06}, Level.ERROR, 'the budget is missed'),
        ({'rms': float('nan')}, Level.ERROR, 'the budget is missed'),
        ({'false': 2}, Level.ERROR, '2 bearings for frames without light'),
        ({'located': 48}, Level.WARN, '12 of 60 lit frames lost'),
        ({'latency': 0.03}, Level.WARN, '30.0 ms median'),
        ({'rate': 40.0}, Level.WARN, '40 frames/s'),
    ],
)
def test_verdict_of_the_self_test(changes: dict[str, Any], level: Level, words: str) -> None:
    """What is right, and each thing that may not be."""
    run = {'rate': 60.0, 'lit': 60, 'located': 60, 'rms': 0.01, 'latency': 0.004,
           'latency_p99': 0.01}
    if 'fault' in changes:
        run = {}
    finding = judge(Run(domain=7, **{**run, **changes}))
    assert finding.level is level
    assert words in finding.message


def test_a_domain_that_is_free() -> None:
    """None of its ports is open."""
    udp = ['  sl  local_address rem_address   st']
    udp += [f'  1: 00000000:{7400 + 250 * domain + 11:04X} 00000000:0000 07'
            for domain in range(1, 102) if domain != 33]
    assert free_domain('\n'.join(udp)) == 33
