"""The tracker for a long time: memory, files, threads, latency and loss stay as they were."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import partial
import os
from statistics import median
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Vector3Stamped
import pytest
from support.processes import PATIENCE, Probe, probe, Process, start

SECONDS = float(os.environ.get('SOAK_SECONDS', 60.0))
SCENE = {'width': 320, 'height': 240, 'focal_length': 400.0}
ARRANGEMENTS: dict[str, dict[str, dict[str, Any]]] = {
    'four processes': {'simulator': SCENE, 'segmenter': {}, 'locator': {}, 'tracker': {}},
    'pipeline': {'pipeline': {'source': 'simulator'} | SCENE},
}
WARM = 12.0  # s of them, until caches, rings and pools have the size that they keep
PERIOD = 1.0  # s between two samples
# MB that a process may seem to grow by: pages that the kernel counts late, and the allocator's
# arenas. A message of a byte that is kept grows by 0.2 MB in an hour, one frame in 1000 by 5 MB in
# a minute.
GROWTH = 3.0
# A process that is late by more than a second in the end is late by more and more.
LATE = 1000.0  # ms
# Of the frames: on a machine that is busy with something else, and the two that count them do so
# up to a second apart. What is lost of late says so in the diagnostics.
LOST = 0.2


@dataclass
class Record:
    """What was seen of a process."""

    memory: list[float] = field(default_factory=list)  # MB, resident
    own: list[float] = field(default_factory=list)  # MB, of no other process
    files: list[int] = field(default_factory=list)
    threads: list[int] = field(default_factory=list)

    def sample(self, process: Process) -> None:
        """Look at the process."""
        self.memory.append(process.memory())
        self.own.append(process.own_memory())
        self.files.append(process.files())
        self.threads.append(process.threads())


class Soaked:
    """One arrangement, watched."""

    def __init__(self, node: Probe, processes: dict[str, Process]) -> None:
        self.node = node
        self.processes = processes
        self.records = {name: Record() for name in processes}
        self.bearings = 0
        self.values: dict[str, dict[str, list[float]]] = {}
        node.create_subscription(Vector3Stamped, 'target/bearing', self._count, 100)
        node.create_subscription(DiagnosticArray, '/diagnostics', self._note, 100)

    def _count(self, message: Vector3Stamped) -> None:
        self.bearings += 1

    def _note(self, message: DiagnosticArray) -> None:
        """Keep the numbers of a diagnostic."""
        for status in message.status:
            name = status.name.split(':')[0]
            if not name.startswith(self.node.get_namespace()):
                continue  # of the other arrangement
            values = self.values.setdefault(name.rpartition('/')[2], {})
            for pair in status.values:
                try:
                    values.setdefault(pair.key, []).append(float(pair.value))
                except ValueError:
                    pass  # a sentence

    def sample(self) -> None:
        """Look at each process."""
        for name, process in self.processes.items():
            assert process.running, name
            self.records[name].sample(process)

    def report(self) -> str:
        """Say what was seen, a line for each process and each node."""
        lines = [f'{self.bearings} bearings']
        for name, record in self.records.items():
            lines.append(
                f'{name}: RSS {_ends(record.memory)} MB, USS {_ends(record.own)} MB, '
                f'{_ends(record.files)} files, {_ends(record.threads)} threads'
            )
        for name, values in sorted(self.values.items()):
            told = ('latency p50 (ms)', 'latency p99 (ms)', 'CPU (%)', 'frames', 'bearings')
            lines.append(
                f'{name}: '
                + ', '.join(f'{key} {_ends(values[key])}' for key in told if values.get(key))
            )
        return '\n'.join(lines)

    def expect_flat(self) -> None:
        """Expect nothing to have grown from the first third to the last."""
        for name, record in self.records.items():
            for values in (record.memory, record.own):
                first, last = _thirds(values)
                assert last - first < GROWTH, (name, first, last)
            for counts in (record.files, record.threads):
                first, last = _thirds(counts)
                assert last <= first, (name, first, last)
        for name, told in self.values.items():
            for latency in ('latency p50 (ms)', 'latency p99 (ms)'):
                if told.get(latency):
                    assert _thirds(told[latency])[1] < LATE, (name, latency)
        sent, taken = (self.values[name]['frames'] for name in ('simulator', 'segmenter'))
        assert taken[-1] - taken[0] > (1.0 - LOST) * (sent[-1] - sent[0])
        assert self.bearings > 0.4 * (1.0 - LOST) * taken[-1]  # half of them are lit


def _thirds(values: Sequence[float]) -> tuple[float, float]:
    """Return the medians of the first and the last third."""
    third = max(len(values) // 3, 1)
    return median(values[:third]), median(values[-third:])


def _ends(values: Sequence[float]) -> str:
    first, last = _thirds(values)
    return f'{first:.4g} -> {last:.4g} (most {max(values):.4g})'


@pytest.mark.timeout(SECONDS + 120.0)
def test_nothing_grows(domain: int) -> None:
    """Four processes and the pipeline side by side, for SOAK_SECONDS, a minute by default."""
    with ExitStack() as stack:
        soaked = {}
        for name, parts in ARRANGEMENTS.items():
            space = f'/{name.split()[0]}'
            node = stack.enter_context(probe(domain, space))
            processes = {
                part: stack.enter_context(
                    start(part, domain, '-r', f'__ns:={space}', **parameters)
                )
                for part, parameters in parts.items()
            }
            soaked[name] = Soaked(node, processes)
        for each in soaked.values():
            each.node.spin_until(partial(getattr, each, 'bearings'), 3.0 * PATIENCE)
            each.node.spin(WARM / len(soaked))
        end = time.monotonic() + SECONDS - WARM  # not so many samples, which take their time too
        while time.monotonic() < end:
            for each in soaked.values():
                each.node.spin(PERIOD / len(soaked))
                each.sample()
        print(f'\nsoaked for {SECONDS:g} s')
        for name, each in soaked.items():
            print(f'{name}: {each.report()}')
        for each in soaked.values():
            each.expect_flat()
