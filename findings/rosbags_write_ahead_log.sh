#!/usr/bin/env bash
# rosbags leaves out what a recorder that was killed had saved in the -wal beside its bag.
#
# Expected: a .db3 is a database of SQLite, which reads the write-ahead log beside it along with it:
# that is what the log is for. All messages that were committed come.
# Happens: the file is opened as one that nobody ever writes to (immutable=1), for which SQLite
# passes over the log. The messages in it are neither counted nor read, without an error.
# Matters: the log is used so that a crash loses nothing. With many small messages all of a bag may
# be in it; they are lost to all when only the .db3 is copied.
#
# rosbags 0.11.9, 30 messages in the .db3 and 29 more that were committed to the log:
#   the module sqlite3: 59
#   rosbags: 30
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    rosbags==0.11.9
"$folder/venv/bin/python" -I - "$folder" <<'END'
import shutil
import sqlite3
import sys
from contextlib import closing
from pathlib import Path

from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import get_typestore, Stores

TYPE = 'std_msgs/msg/UInt8'
folder = Path(sys.argv[1])

store = get_typestore(Stores.ROS2_JAZZY)
data = bytes(store.serialize_cdr(store.types[TYPE](data=7), TYPE))
with Writer(folder / 'bag', version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
    connection = bag.add_connection('/light', TYPE, typestore=store)
    for nanoseconds in range(30):
        bag.write(connection, nanoseconds, data)

with closing(sqlite3.connect(folder / 'bag' / 'bag.db3')) as recorder:
    recorder.execute('PRAGMA journal_mode=WAL')
    with recorder:
        recorder.executemany(
            'INSERT INTO messages (topic_id, timestamp, data) VALUES (1, ?, ?)',
            [(nanoseconds, data) for nanoseconds in range(30, 59)],
        )
    shutil.copytree(folder / 'bag', folder / 'killed')  # before the log is put into the .db3

path = folder / 'killed' / 'bag.db3'
with AnyReader([path]) as reader:
    listed, read = reader.message_count, sum(1 for _ in reader.messages())
with closing(sqlite3.connect(path)) as database:
    (whole,) = database.execute('SELECT count(*) FROM messages').fetchone()
print('the module sqlite3:', whole)
print('rosbags:', read)
if (whole, listed, read) != (59, 30, 30):
    raise SystemExit('rosbags no longer passes over the write-ahead log of a bag.')
END
