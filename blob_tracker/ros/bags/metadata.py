"""What metadata.yaml says of a bag, as far as its recorder came to write it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path, PurePath
import re
from typing import Any

from blob_tracker.ros.bags.qos import profiles
from blob_tracker.ros.bags.topic import Topic
import yaml

NAME = 'metadata.yaml'
SUFFIXES = ('.mcap', '.db3', '.bag', '.mcap.zstd', '.db3.zstd')


@dataclass(frozen=True)
class Metadata:
    """
    The files of a bag and what is said of them.

    Parameters
    ----------
    files : list of Path
        Those that are there, in the order in which they were recorded.
    promised : dict or None
        The number of messages of each topic; None if nothing is said.
    flaws : list of str
        What is wrong with it.

    """

    files: list[Path]
    promised: dict[Topic, int] | None = None
    flaws: list[str] = field(default_factory=list)


def files_of(folder: Path) -> list[Path]:
    """Return the files of a bag in a folder: bag_2.mcap before bag_10.mcap."""
    return sorted(
        (each for each in folder.iterdir() if each.name.endswith(SUFFIXES) and each.is_file()),
        key=lambda file: [
            (int(part), '') if part.isdigit() else (-1, part)
            for part in re.split(r'(\d+)', file.name)
        ],
    )


def read_metadata(folder: Path) -> Metadata:
    """Return what is known of the bag in a folder; never fails for a bad metadata.yaml."""
    there = files_of(folder)
    path = folder / NAME
    if not path.is_file():
        # A folder of bags of ROS 1 has none.
        bare = there and all(each.suffix == '.bag' for each in there)
        return Metadata(there, flaws=[] if bare else [f'it has no {NAME}'])
    try:
        content = yaml.safe_load(path.read_text(encoding='utf-8'))
        said = content['rosbag2_bagfile_information']
        names = [PurePath(each).name for each in said['relative_file_paths']]
        promised = {
            _topic(each['topic_metadata']): int(each['message_count'])
            for each in said['topics_with_message_count']
        }
    except (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError, ValueError,
            AttributeError):
        return Metadata(there, flaws=[f'its {NAME} cannot be read'])
    if not names or not said.get('storage_identifier'):
        # As a recorder writes it at its start, to be filled in at its end.
        return Metadata(there, flaws=[f'its {NAME} was not finished'])
    flaws = [
        f'{name}, which its {NAME} names, is not there' for name in names
        if not (folder / name).is_file()
    ]
    flaws += [
        f'{each.name} is not in its {NAME} and is left out' for each in there
        if each.name not in names
    ]
    return Metadata(
        [folder / name for name in names if (folder / name).is_file()], promised, flaws)


def _topic(said: dict[str, Any]) -> Topic:
    return Topic(
        str(said['name']), str(said['type']), str(said['serialization_format']),
        profiles(said.get('offered_qos_profiles')),
    )
