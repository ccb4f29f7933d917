"""Shared memory, through which Fast DDS hands over images."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
import fcntl
import os
from pathlib import Path
import re

from blob_tracker.commands.doctor.finding import error, Finding, ok, warn
from blob_tracker.ros.diagnostics.shared_memory import by_network, FOLDER

MIB = 2**20
SEGMENT = 35 * MIB  # of a process with config/fastdds.xml: 32 MiB of data, and the descriptors
PROCESSES = 5  # camera, segmenter, locator, tracker, and one that listens
_SEGMENT_LOCK = re.compile(r'fast(rtps|dds)_[0-9a-f]{16}_el')


def check_shared_memory(folder: Path = FOLDER) -> Iterator[Finding]:
    """
    Look at the folder of the segments.

    Parameters
    ----------
    folder : Path
        Where POSIX shared memory lies.

    """
    if not folder.is_dir():
        yield error(
            'shared memory',
            f'there is no {folder}: images go over UDP, and many are lost',
            'mount it',
            f'sudo mkdir -p {folder} && sudo mount -t tmpfs tmpfs {folder}',
        )
        return
    if not os.access(folder, os.W_OK | os.X_OK):
        yield error(
            'shared memory',
            f'{folder} may not be written to: images go over UDP, and many are lost',
            'everybody may, as in /tmp',
            f'sudo chmod 1777 {folder}',
        )
        return
    space = os.statvfs(folder)
    yield judge_space(folder, space.f_blocks * space.f_frsize, space.f_bavail * space.f_frsize)
    yield judge_leftovers(folder, *leftovers(folder))
    yield from judge_users(other_users(folder), os.geteuid())


def judge_space(folder: Path, size: int, free: int) -> Finding:
    """Return the finding on the size and the free space of the folder, bytes."""
    words = f'{folder}: {free // MIB} of {size // MIB} MiB are free'
    need = f'each process that runs nodes takes up to {SEGMENT // MIB} MiB'
    if free >= PROCESSES * SEGMENT:
        return ok('shared memory', f'{words}; {need}')
    # Docker gives 64 MiB: one process has its segment.
    verdict = 'not enough for one' if free < SEGMENT else f'too little for {PROCESSES} of them'
    message = f'{words}; {need}: {verdict}, and what has none goes over UDP with losses'
    level = error if free < SEGMENT else warn
    if size < PROCESSES * SEGMENT:
        return level(
            'shared memory', message,
            'make it larger; a container is started with --shm-size=1g or --ipc=host',
            f'sudo mount -o remount,size=1g {folder}',
        )
    return level('shared memory', message, 'see what fills it', f'ls -lS {folder} | head')


def leftovers(folder: Path) -> tuple[int, int, int]:
    """
    Count the segments of Fast DDS.

    Whoever owns one holds the lock of the file beside it, with the suffix _el, until it dies.

    Returns
    -------
    int, int, int
        Segments of living processes; those of dead ones, and their bytes.

    """
    alive = dead = size = 0
    for lock in folder.iterdir():
        if not _SEGMENT_LOCK.fullmatch(lock.name):
            continue
        try:
            if _is_held(lock):
                alive += 1
                continue
            dead += 1
            size += lock.with_name(lock.name.removesuffix('_el')).stat().st_blocks * 512
        except OSError:
            continue  # it went meanwhile, or is another user's
    return alive, dead, size


def _is_held(lock: Path) -> bool:
    """Tell whether somebody holds a lock for himself; a shared one disturbs nobody."""
    fd = os.open(lock, os.O_RDONLY | os.O_CLOEXEC)
    try:
        fcntl.flock(fd, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(fd)
    return False


def judge_leftovers(folder: Path, alive: int, dead: int, size: int) -> Finding:
    """Return the finding on what dead processes have left."""
    if not dead:
        return ok('shared memory', f'no segments of dead processes, {alive} of living ones')
    return warn(
        'shared memory',
        f'{dead} segments of dead processes hold {size // MIB} MiB of {folder} ({alive} belong '
        'to living ones)',
        'remove them; it leaves the living alone',
        'fastdds shm clean',
    )


def other_users(folder: Path) -> list[int]:
    """Return the ids of other users with segments of Fast DDS in a folder."""
    users = set()
    for lock in folder.iterdir():
        if _SEGMENT_LOCK.fullmatch(lock.name):
            try:
                users.add(lock.stat().st_uid)
            except OSError:
                continue  # it went meanwhile
    return sorted(users - {os.geteuid()})


def judge_users(others: Sequence[int], own: int) -> Iterator[Finding]:
    """Return the finding on nodes of other users, where there are any."""
    if others:
        yield warn(
            'shared memory',
            f'nodes of other users run or have run here (uid {", ".join(map(str, others))}, '
            f'this one {own}): nodes of two users find each other, and nothing arrives',
            'run all as one user, or have those of this terminal do without shared memory',
            by_network(),
        )
