#!/usr/bin/env bash
# rosbags reads no message of an MCAP file that has an index of its chunks but none in them.
#
# Expected: each of MCAP's indexes is optional; a reader that lacks one looks through the chunks.
# Happens: without any index all messages come, and with all of them. With that of the chunks alone,
# which is smaller and enough to find a time, the right number is listed and none is read.
# Matters: such a file is valid and whole, and other readers and viewers show it; a writer's option
# for smaller files makes it.
#
# rosbags 0.11.9, mcap 1.6.0, a file of 20 messages:
#   all indexes: mcap 20; rosbags lists 20, reads 20
#   no index: mcap 20; rosbags lists 20, reads 20
#   of chunks: mcap 20; rosbags lists 20, reads 0
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    mcap==1.6.0 rosbags==0.11.9
"$folder/venv/bin/python" -I - "$folder/bag.mcap" <<'END'
import sys
from pathlib import Path

from mcap.reader import make_reader
from mcap.writer import IndexType, Writer
from rosbags.highlevel import AnyReader

path = Path(sys.argv[1])
as_described = True
for name, indexes, expected in (
        ('all indexes', IndexType.ALL, 20),
        ('no index', IndexType.NONE, 20),
        ('of chunks', IndexType.CHUNK, 0)):
    bag = Writer(str(path), index_types=indexes)
    bag.start('ros2')
    schema = bag.register_schema('std_msgs/msg/UInt8', 'ros2msg', b'uint8 data')
    channel = bag.register_channel('/light', 'cdr', schema)
    for nanoseconds in range(1, 21):
        bag.add_message(channel, nanoseconds, b'\0\1\0\0\7', nanoseconds)
    bag.finish()
    with path.open('rb') as file:
        whole = sum(1 for _ in make_reader(file).iter_messages())
    with AnyReader([path]) as reader:
        listed, read = reader.message_count, sum(1 for _ in reader.messages())
    print(f'{name}: mcap {whole}; rosbags lists {listed}, reads {read}')
    as_described &= (whole, listed, read) == (20, 20, expected)

if not as_described:
    raise SystemExit('rosbags no longer reads nothing if only the chunks have an index.')
END
