#!/usr/bin/env bash
# rosbags refuses a bag if the definition of one of its messages has the line ends of Windows.
#
# Expected: definitions are stored in the bag as the .msg files have them, and CR LF ends a line for
# ROS 2, as the limit of a wstring is valid to it. If not, that topic cannot be read.
# Happens: either one is an error when AnyReader opens the bag, which parses the definitions of all
# topics first, wanted or not. No topic can be read.
# Matters: a status message of a package that was checked out on Windows takes the pictures with it.
# Nobody sees it in an editor.
#
# rosbags 0.11.9, a topic of UInt8 beside one with a definition of its own:
#   'uint8 code\nuint8 level\n': 2 topics
#   'uint8 code\r\nuint8 level\r\n': Could not parse
#   'wstring<=5 text\n': Could not parse
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    mcap==1.6.0 rosbags==0.11.9
"$folder/venv/bin/python" -I - "$folder/bag.mcap" <<'END'
import sys
from pathlib import Path

from mcap.writer import Writer
from rosbags.highlevel import AnyReader, AnyReaderError

DEFINITIONS = {  # and whether the bag can be read
    'uint8 code\nuint8 level\n': True,
    'uint8 code\r\nuint8 level\r\n': False,
    'wstring<=5 text\n': False,
}
path = Path(sys.argv[1])

as_described = True
for definition, expected in DEFINITIONS.items():
    bag = Writer(str(path))
    bag.start('ros2')
    for topic, name, text in (('/light', 'std_msgs/msg/UInt8', 'uint8 data\n'),
                              ('/status', 'example_msgs/msg/Status', definition)):
        schema = bag.register_schema(name, 'ros2msg', text.encode())
        channel = bag.register_channel(topic, 'cdr', schema)
        bag.add_message(channel, 1, b'\0\1\0\0\0\0\0\0\0\0', 1)
    bag.finish()
    try:
        with AnyReader([path]) as reader:
            told = f'{len(reader.topics)} topics'
    except AnyReaderError as error:
        told = str(error).partition(':')[0]
    print(f'{definition!r}: {told}')
    as_described &= told == ('2 topics' if expected else 'Could not parse')

if not as_described:
    raise SystemExit('rosbags no longer refuses a bag for the line ends of one definition.')
END
