#!/usr/bin/env bash
# rosbags reads no message of a bag whose metadata.yaml names another quality of service.
#
# Expected: which QoS a publisher offered while it was recorded is a remark for the one who plays
# the bag; a reader of files goes by topic and type.
# Happens: a topic of metadata.yaml and that of the data file are the same only if their QoS are.
# If not, the topic is listed with the number of its messages, and none of them comes, without an
# error.
# Matters: metadata.yaml is text, which people edit and tools write anew. Such a bag seems to be
# one in which nothing was seen.
#
# rosbags 0.11.9, a bag of 5 messages, for sqlite3 and mcap alike:
#   as it was written: listed 5, read 5
#   reliable made best_effort: listed 5, read 0
#   depth 10 made 1: listed 5, read 0
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    rosbags==0.11.9
"$folder/venv/bin/python" -I - "$folder" <<'END'
import sys
from pathlib import Path

from rosbags.highlevel import AnyReader
from rosbags.interfaces import (
    Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import get_typestore, Stores

TYPE = 'std_msgs/msg/UInt8'
FOREVER = QosTime(2147483647, 4294967295)
QOS = Qos(
    QosHistory.KEEP_LAST, 10, QosReliability.RELIABLE, QosDurability.VOLATILE, FOREVER, FOREVER,
    QosLiveliness.AUTOMATIC, FOREVER, False,
)
EDITS = {
    'as it was written': ('', '', 5),
    'reliable made best_effort': ('reliability: reliable', 'reliability: best_effort', 0),
    'depth 10 made 1': ('depth: 10', 'depth: 1', 0),
}

store = get_typestore(Stores.ROS2_JAZZY)
data = store.serialize_cdr(store.types[TYPE](data=7), TYPE)
as_described = True
for plugin in StoragePlugin:
    path = Path(sys.argv[1], plugin.name.lower())
    with Writer(path, version=9, storage_plugin=plugin) as bag:
        connection = bag.add_connection('/light', TYPE, typestore=store, offered_qos_profiles=[QOS])
        for nanoseconds in range(1, 6):
            bag.write(connection, nanoseconds, data)
    metadata = path / 'metadata.yaml'
    written = metadata.read_text()
    for name, (old, new, expected) in EDITS.items():
        as_described &= old in written
        metadata.write_text(written.replace(old, new))
        with AnyReader([path]) as reader:
            listed = reader.topics['/light'].msgcount
            read = sum(1 for _ in reader.messages())
        print(f'{path.name}, {name}: listed {listed}, read {read}')
        as_described &= (listed, read) == (5, expected)

if not as_described:
    raise SystemExit('rosbags no longer passes over a topic whose QoS was edited.')
END
