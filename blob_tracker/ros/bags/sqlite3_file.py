"""A .db3 file of rosbag2, with what its recorder had not yet written into it when it ended."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path
import shutil
from tempfile import TemporaryDirectory
from typing import Any

import apsw  # comes with rosbags; a tenth faster than the standard library's
from blob_tracker.ros.bags.qos import profiles
from blob_tracker.ros.bags.topic import Message, RecordingError, Topic

MAGIC = b'SQLite format 3\0'
FAULTS = (apsw.Error, UnicodeDecodeError)  # the latter of the text in a damaged file
READ = apsw.SQLITE_OPEN_READONLY | apsw.SQLITE_OPEN_URI


class Sqlite3File:
    """A file of rosbag2's storage sqlite3, of any of its schemas; see `BagFile`."""

    def __init__(self, path: Path) -> None:
        self.promised: dict[Topic, int] | None = None
        self.flaws: list[str] = []
        self._path = path
        self._copies: TemporaryDirectory[str] | None = None
        self._made: Path | None = None  # by SQLite, beside the file, to read its log
        self._database = self._connected()
        try:
            self._topics = self._read_topics()
        except FAULTS as error:
            self.close()
            raise RecordingError(
                f'{path} is not a readable bag: {error}; copy it again, or save what is left of '
                f'it: `sqlite3 {path.name} .recover`'
            ) from None
        except RecordingError:
            self.close()
            raise
        self.topics = list(self._topics.values())

    def counts(self) -> dict[Topic, int]:
        """Return how many messages of each topic are there."""
        rows = self._rows('SELECT topic_id, count(*) FROM messages GROUP BY topic_id')
        found = dict.fromkeys(self.topics, 0)
        for number, count in rows:
            if number in self._topics:
                found[self._topics[number]] += count
            else:
                self._flawed(f'{count} of its messages are of a topic that it does not name')
        return found

    def span(self) -> tuple[int, int] | None:
        """Return the time of the first message and of the last, ns; None without any."""
        # One at a time: both at once are not taken from the index.
        ends = [
            next(self._rows(f'SELECT {which}(timestamp) FROM messages'), (None,))[0]
            for which in ('min', 'max')
        ]
        return None if None in ends else (ends[0], ends[1])

    def messages(self, topics: Collection[Topic]) -> Iterator[Message]:
        """Yield the messages of topics in the order of their times."""
        numbers = [number for number, topic in self._topics.items() if topic in topics]
        rows = self._rows(
            'SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN '
            f'({",".join("?" * len(numbers))}) ORDER BY timestamp, id', numbers)
        for number, recorded_ns, data in rows:
            yield Message(self._topics[number], recorded_ns, data)

    def close(self) -> None:
        """Close it."""
        self._database.close()
        if self._made is not None:
            self._made.unlink(missing_ok=True)
        if self._copies is not None:
            self._copies.cleanup()

    def _rows(self, query: str, values: Collection[int] = ()) -> Iterator[tuple[Any, ...]]:
        """Yield the rows of a query, as far as the file is whole."""
        try:
            yield from self._database.execute(query, tuple(values))
        except FAULTS as error:
            self._flawed(str(error))

    def _flawed(self, flaw: str) -> None:
        if flaw not in self.flaws:
            self.flaws.append(flaw)

    def _connected(self) -> apsw.Connection:
        """
        Open the database to be read.

        A recorder that was killed leaves its last messages in a log beside it (-wal), or a
        transaction that must be taken back (-journal), which is done in a copy: the bag stays as
        it is.
        """
        address = self._path.absolute().as_uri()
        log, journal = (
            each if each.exists() and each.stat().st_size else None
            for each in (Path(f'{self._path}-wal'), Path(f'{self._path}-journal'))
        )
        if log is None and journal is None:
            # Without immutable SQLite wants to write beside a file that was once logged.
            return apsw.Connection(f'{address}?immutable=1', flags=READ)
        if journal is None:
            index = Path(f'{self._path}-shm')
            self._made = None if index.exists() else index
            database = apsw.Connection(f'{address}?mode=ro', flags=READ)
            try:
                database.execute('SELECT count(*) FROM sqlite_master').fetchone()
                return database
            except apsw.Error:  # in a folder in which nothing can be written
                database.close()
        self._copies = TemporaryDirectory(prefix='bag_')
        for file in (self._path, log, journal):
            if file is not None:
                shutil.copyfile(file, Path(self._copies.name, file.name))
        return apsw.Connection(str(Path(self._copies.name, self._path.name)))

    def _read_topics(self) -> dict[int, Topic]:
        columns = {row[1] for row in self._database.execute('PRAGMA table_info(topics)')}
        if not columns or not self._database.execute('PRAGMA table_info(messages)').fetchone():
            raise RecordingError(f'{self._path} is a database, but no bag: it has no messages')
        qos = 'offered_qos_profiles' if 'offered_qos_profiles' in columns else "''"
        return {
            number: Topic(name, kind, encoding, profiles(written))
            for number, name, kind, encoding, written in self._database.execute(
                f'SELECT id, name, type, serialization_format, {qos} FROM topics ORDER BY id')
        }
