"""The profile of Fast DDS: whether its shared-memory segment is large enough for images."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
import os
from pathlib import Path
import re
import subprocess
import sys
from xml.etree import ElementTree

from blob_tracker.commands.doctor.finding import error, Finding, ok, warn

VARIABLE = 'FASTRTPS_DEFAULT_PROFILES_FILE'  # Fast DDS 2, that of Jazzy
LATER_VARIABLE = 'FASTDDS_DEFAULT_PROFILES_FILE'  # Fast DDS 3
ENOUGH = 10 * 1920 * 1200  # bytes: a publisher's queue of ten large images
DEFAULT = 512 * 1024  # bytes, without a profile
LONGEST = 30.0  # s to start a node
_COLOUR = re.compile('\x1b\\[[0-9;]*m')
_COMPLAINT = re.compile(r'\[XMLPARSER Error\] (.*?)(?: -> Function .*)?$', re.MULTILINE)
_SPACE = {'dds': 'http://www.eprosima.com'}


def check_profile(
    environment: Mapping[str, str], shipped: Path, rmw: str = 'rmw_fastrtps_cpp'
) -> Iterator[Finding]:
    """
    Look at the file that the environment names.

    Parameters
    ----------
    environment : mapping
        Environment variables.
    shipped : Path
        The profile that comes with the package.
    rmw : str
        The middleware: others have no use for it.

    """
    if 'fastrtps' not in rmw:
        return
    export = f'export {VARIABLE}={shipped}'
    name = environment.get(VARIABLE, '')
    if not name:
        later = environment.get(LATER_VARIABLE, '')
        why = f'{LATER_VARIABLE} is set, which Fast DDS 2 does not read; ' if later else ''
        yield warn(
            'Fast DDS',
            f'{why}{VARIABLE} is not set: the segment has 512 KiB, less than two 640x480 images; '
            'of those up to 3 % are lost at 60 Hz, of 1920x1200 images 30 to 40 % at 10 Hz and '
            'nearly all at 30 Hz (demo and launch files set it by themselves)',
            'before the nodes start',
            export,
        )
        return
    path = Path(name)
    if not path.is_file():
        yield error(
            'Fast DDS', f'{VARIABLE} is {name}, and there is no such file', 'name one', export
        )
        return
    try:
        size = segment_size(path)
    except ElementTree.ParseError as fault:
        yield error(
            'Fast DDS', f'{path} is not well-formed XML ({fault}); Fast DDS takes none of it',
            'mend it, or take the one that comes with the package', export,
        )
        return
    except ValueError:
        size = 0  # of which Fast DDS has more to say
    if complaint := complaint_about(path, environment):
        yield error(
            'Fast DDS', f'Fast DDS drops {path} whole: {complaint}',
            'mend it, or take the one that comes with the package', export,
        )
        return
    if size >= ENOUGH:
        yield ok('Fast DDS', f'{path}: a segment of {size / 2**20:g} MiB')
        return
    yield warn(
        'Fast DDS',
        f'{path} gives a segment of {size} bytes; ten 1920x1200 images, which a publisher keeps, '
        f'have {ENOUGH}',
        'raise segment_size in it, or take the one that comes with the package',
        export,
    )


def complaint_about(path: Path, environment: Mapping[str, str]) -> str:
    """
    Return what Fast DDS itself says against a profile; empty if it takes it.

    One tag that it does not know, or a value out of range, and it goes on without any of it.
    """
    tried = subprocess.run(
        [sys.executable, '-c', 'import rclpy; rclpy.init(); rclpy.create_node("doctor")'],
        env={**os.environ, **environment, VARIABLE: str(path)}, capture_output=True, text=True,
        timeout=LONGEST, check=False,
    )
    words = _COLOUR.sub('', tried.stdout + tried.stderr)
    found = _COMPLAINT.search(words)
    return '' if found is None else found[1].strip()


def segment_size(path: Path) -> int:
    """
    Return the size of the shared-memory segment of the participants with the default profile.

    Returns
    -------
    int
        bytes; that of Fast DDS itself where the file does not say, 0 where it has no shared
        memory.

    Raises
    ------
    ElementTree.ParseError
        It is no XML.

    """
    root = ElementTree.parse(path).getroot()
    participant = root.find('.//dds:participant[@is_default_profile="true"]', _SPACE)
    if participant is None:
        return DEFAULT
    builtin = participant.findtext('.//dds:useBuiltinTransports', 'true', _SPACE)
    sizes = [DEFAULT] if builtin.strip() in ('true', '1') else [0]
    used = {
        (element.text or '').strip()
        for element in participant.findall('.//dds:userTransports/dds:transport_id', _SPACE)
    }
    for transport in root.findall('.//dds:transport_descriptor', _SPACE):
        kind = transport.findtext('dds:type', '', _SPACE).strip()
        if transport.findtext('dds:transport_id', '', _SPACE).strip() in used and kind == 'SHM':
            sizes.append(int(transport.findtext('dds:segment_size', str(DEFAULT), _SPACE)))
    return max(sizes)


def fast_dds(folders: Sequence[Path]) -> Path | None:
    """Return the library of Fast DDS that nodes load, None if there is none."""
    for folder in folders:
        for name in ('libfastrtps.so', 'libfastdds.so'):
            # The longest name has the version; the wheels have copies where apt has links.
            found = sorted(folder.glob(f'{name}*'), key=lambda path: len(path.name))
            if found:
                return found[-1]
    return None
