"""The shared memory in which Fast DDS hands messages over, of this process and of others."""

from __future__ import annotations

from collections.abc import Mapping
import os
from pathlib import Path
from xml.etree import ElementTree

from blob_tracker.resources import config_path

VARIABLE = 'FASTRTPS_DEFAULT_PROFILES_FILE'  # what Fast DDS 2, that of Jazzy, reads
FOLDER = Path('/dev/shm')
DEFAULT_BYTES = 512 * 1024  # bytes, without a profile
_VENDOR = b'\x01\x0f'  # of Fast DDS, in the GUID of all that it makes (RTPS, 9.3.1.5)


def segment_size(environment: Mapping[str, str]) -> int:
    """Return the bytes of the segment in a process with these environment variables."""
    try:
        root = ElementTree.parse(environment.get(VARIABLE, '')).getroot()
        return max((int(each.text or 0) for each in root.findall('.//{*}segment_size')),
                   default=DEFAULT_BYTES)
    except (OSError, ValueError, ElementTree.ParseError):
        return DEFAULT_BYTES  # Fast DDS does without a profile that it cannot read, too


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


def environment_of(gid: bytes) -> dict[str, str] | None:
    """
    Return the environment variables with which the process of an endpoint was started.

    Parameters
    ----------
    gid : bytes
        Of an endpoint on this machine. Fast DDS puts the low 16 bits of the process id in it.

    Returns
    -------
    dict or None
        None where the process is another user's, or in a container of its own.

    """
    if gid[:2] != _VENDOR:
        return None
    found = []
    for process in _processes(gid):
        try:
            if 'fastrtps' in (process / 'maps').read_text():
                found.append((process / 'environ').read_bytes())
        except OSError:
            return None
    if len(found) != 1:
        return None
    pairs = (each.partition('=') for each in os.fsdecode(found[0]).split('\0') if each)
    return {name: value for name, _, value in pairs}


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
        Empty where nothing does, as far as can be seen.

    """
    if gid[:2] != _VENDOR:
        return ''
    reason = 'its process is not seen from here, as one in a container'
    for process in _processes(gid):
        try:
            user = process.stat().st_uid
            if user != os.geteuid():
                reason = f'it runs as another user (uid {user}, this one {os.geteuid()})'
            elif 'fastrtps' in (process / 'maps').read_text():
                theirs = process / 'root' / folder.relative_to('/')
                if os.path.samestat(theirs.stat(), folder.stat()):
                    return ''
                reason = f'it has a {folder} of its own, as in a container'
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
