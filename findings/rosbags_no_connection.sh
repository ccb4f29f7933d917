#!/usr/bin/env bash
# rosbags reads every message of a bag when no topic of it is asked for.
#
# Expected: messages(connections=[]) of AnyReader and Reader yields nothing, as a filter that lets
# nothing through.
# Happens: an empty list is no filter, says its help: all messages come.
# Matters: the list is mostly made of the connections whose topic has a given name. One letter of it
# wrong, and every message of other topics is taken for one of this; if they are of the same type,
# a second camera's frames, nothing fails.
#
# rosbags 0.11.9, of a bag with 5 messages of /left and 5 of /right:
#   /left: 5
#   /letf: 10
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    rosbags==0.11.9
"$folder/venv/bin/python" -I - "$folder/bag" <<'END'
import sys
from pathlib import Path

from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Writer
from rosbags.typesys import get_typestore, Stores

TYPE = 'std_msgs/msg/UInt8'

path = Path(sys.argv[1])
store = get_typestore(Stores.ROS2_JAZZY)
data = store.serialize_cdr(store.types[TYPE](data=7), TYPE)
with Writer(path, version=9) as bag:
    for topic in ('/left', '/right'):
        connection = bag.add_connection(topic, TYPE, typestore=store)
        for nanoseconds in range(1, 6):
            bag.write(connection, nanoseconds, data)

found = []
with AnyReader([path]) as reader:
    for topic in ('/left', '/letf'):
        wanted = [each for each in reader.connections if each.topic == topic]
        found.append(sum(1 for _ in reader.messages(connections=wanted)))
        print(f'{topic}: {found[-1]}')

if found != [5, 10]:
    raise SystemExit('rosbags no longer reads all messages for an empty list of connections.')
END
