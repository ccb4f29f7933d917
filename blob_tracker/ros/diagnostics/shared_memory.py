"""The shared memory in which Fast DDS hands messages over, of this process and of others."""

from __future__ import annotations

from contextlib import suppress
import os
from pathlib import Path
import re

from blob_tracker.resources import config_path

VARIABLE = 'FASTRTPS_DEFAULT_PROFILES_FILE'  # what Fast DDS 2, that of Jazzy, reads
FOLDER = Path('/dev/shm')
DEFAULT_BYTES = 512 * 1024  # bytes, without a profile
_SEGMENT_LOCK = re.compile(r'fast(rtps|dds)_[0-9a-f]{16}_el')
_VENDOR = b'\x01\x0f'  # of Fast DDS, in the GUID of all that it makes (RTPS, 9.3.1.5)


def export() -> str:
    """Return the line that puts the profile of this package into effect in a terminal."""
    return f'export {VARIABLE}={config_path("fastdds.xml")}'


def by_network() -> str:
    """Return the line that has a terminal's nodes do without shared memory."""
    return (
        f'unset {VARIABLE}; export ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET '
        'FASTDDS_BUILTIN_TRANSPORTS=UDPv4'
    )


def same_host(gid: bytes, other: bytes) -> bool:
    """Tell whether two endpoints are on one machine; unknown ones, of other middlewares, are."""
    return gid[:2] != _VENDOR or other[:2] != _VENDOR or gid[2:4] == other[2:4]


def segment_size(gid: bytes, folder: Path = FOLDER) -> int | None:
    """
    Return the size of the segment of an endpoint's process.

    It is looked at, as what a profile asks for may not be what there is: Fast DDS does without a
    profile in which it does not understand a word.

    Parameters
    ----------
    gid : bytes
        Of an endpoint on this machine. Fast DDS puts the low 16 bits of the process id in it.
    folder : Path
        Where POSIX shared memory lies.

    Returns
    -------
    int or None
        bytes, with the descriptors; None if the process is another user's or in a container of
        its own, or has none.

    """
    if gid[:2] != _VENDOR:
        return None
    sizes = []
    for process in _processes(gid):
        with suppress(OSError):  # it ended meanwhile, or may not be looked at
            inside = process / 'root' / folder.relative_to('/')
            for each in (process / 'fd').iterdir():
                with suppress(OSError):  # that file was closed
                    name = Path(os.readlink(each)).name
                    # Only the owner of a segment keeps the file beside it open, and its lock.
                    if _SEGMENT_LOCK.fullmatch(name):
                        sizes.append((inside / name.removesuffix('_el')).stat().st_size)
    return max(sizes, default=None)


def barrier(gid: bytes, folder: Path = FOLDER) -> str:
    """
    Return what keeps this process and that of an endpoint from sharing memory.

    Two that are on one machine, by the addresses of their network, are matched by Fast DDS and
    talk through shared memory alone, whether both can reach it or not.

    Parameters
    ----------
    gid : bytes
        Of an endpoint on this machine.
    folder : Path
        Where POSIX shared memory lies.

    Returns
    -------
    str
        Empty where nothing does, as far as can be seen; with what has to be so where that is not
        sure.

    """
    if gid[:2] != _VENDOR:
        return ''
    # One in a container that shares the folder, or whose lease has not ended, looks the same.
    reason = (
        'its process is not visible from here; if it has not ended, and does publish, it is in a '
        f'container with its own {folder}'
    )
    for process in _processes(gid):
        try:
            user = process.stat().st_uid
            if user != os.geteuid():
                reason = f'it runs as another user (uid {user}, this one {os.geteuid()})'
            elif 'fastrtps' in (process / 'maps').read_text():
                theirs = process / 'root' / folder.relative_to('/')
                if os.path.samestat(theirs.stat(), folder.stat()):
                    return ''
                reason = f'it has its own {folder}, as in a container'
        except OSError:  # it ended meanwhile, or may not be looked at
            continue
    return reason


def _processes(gid: bytes) -> list[Path]:
    """Return the folders of the processes that an endpoint may belong to, by its GUID."""
    low = int.from_bytes(gid[4:6], 'little')
    return [
        each for each in Path('/proc').iterdir()
        if each.name.isdigit() and int(each.name) & 0xFFFF == low
    ]
