"""Shared memory that is missing, small, full of the dead, or of others."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

from blob_tracker.commands.doctor import shared_memory
from blob_tracker.commands.doctor.finding import Level, ok
import pytest
from support.findings import told

MIB = 2**20


def test_shared_memory_that_is_not_there(tmp_path: Path) -> None:
    """No folder; one that is there is measured."""
    told(shared_memory.check_shared_memory(tmp_path / 'shm'), Level.ERROR, 'there is no ', 'mount')
    (tmp_path / 'shm').mkdir()
    space, left = shared_memory.check_shared_memory(tmp_path / 'shm')
    assert 'MiB are free' in space.message
    assert left == ok('shared memory', 'no segments of dead processes, 0 of living ones')


@pytest.mark.parametrize(
    'size, free, level, words',
    [
        (64, 64, Level.WARN, '--shm-size=1g'),  # as Docker comes
        (64, 30, Level.ERROR, '--shm-size=1g'),
        (200, 130, Level.WARN, 'too little for 5'),
        (1000, 30, Level.ERROR, 'ls -lS'),
        (1000, 500, Level.OK, '500 of 1000 MiB'),
    ],
)
def test_room_in_shared_memory(size: int, free: int, level: Level, words: str) -> None:
    """Four processes with their segments of 35 MiB have to fit."""
    told([shared_memory.judge_space(Path('/s'), size * MIB, free * MIB)], level, words)


def test_segments_of_the_dead(tmp_path: Path) -> None:
    """A lock that nobody holds; locks of ports and files of others do not count."""
    for name in ('fastrtps_0123456789abcdef', 'fastrtps_fedcba9876543210'):
        (tmp_path / name).write_bytes(bytes(2 * MIB))
        (tmp_path / f'{name}_el').touch()
    (tmp_path / 'fastrtps_port7411_el').touch()
    (tmp_path / 'lttng-ust-wait').touch()
    with open(tmp_path / 'fastrtps_fedcba9876543210_el') as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        alive, dead, size = shared_memory.leftovers(tmp_path)
        assert (alive, dead, size // MIB) == (1, 1, 2)
    told([shared_memory.judge_leftovers(tmp_path, alive, dead, size)], Level.WARN,
         '1 segments of dead processes hold 2 MiB', 'fastdds shm clean')
    assert shared_memory.leftovers(tmp_path)[:2] == (0, 2)


def test_nodes_of_other_users(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each once, by the locks of their segments; one's own, ports and other files do not count."""
    for name in ('fastrtps_0123456789abcdef_el', 'fastrtps_port7411_el', 'lttng-ust-wait'):
        (tmp_path / name).touch()
    assert shared_memory.other_users(tmp_path) == []
    assert list(shared_memory.judge_users([], 1000)) == []
    own = os.geteuid()
    monkeypatch.setattr(os, 'geteuid', lambda: own + 1)
    assert shared_memory.other_users(tmp_path) == [own]
    told(shared_memory.judge_users([1001, 1002], 1000), Level.WARN,
         'other users run or have run here (uid 1001, 1002, this one 1000)',
         'FASTDDS_BUILTIN_TRANSPORTS=UDPv4')
