"""Findings of the doctor, looked at."""

from __future__ import annotations

from collections.abc import Iterable

from blob_tracker.commands.doctor.finding import Finding, Level


def one(findings: Iterable[Finding]) -> Finding:
    """Return the only finding."""
    (finding,) = findings
    return finding


def told(findings: Iterable[Finding], level: Level, *words: str) -> None:
    """Assert that there is one finding, how bad it is, and what is in it."""
    finding = one(findings)
    everything = f'{finding.message} {finding.advice} {finding.command}'
    assert finding.level is level, everything
    for word in words:
        assert word in everything
    # Whoever is told that something is wrong is told what to do.
    assert level is Level.OK or finding.advice or finding.command or ';' in finding.message
