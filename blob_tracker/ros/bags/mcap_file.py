"""
An mcap file, by its index or, where it has none, by all of its records.

A recorder that was killed leaves a file without its last part, index and all. The libraries
refuse it (rosbags), or lose the chunk that was cut (mcap). Here it is read to its last whole
message, as are files without message indexes, or with messages out of order.

What is decompressed at once is a piece: a chunk, or a megabyte of messages outside of chunks.
Pieces are read in the order of their first messages and kept until no later one can begin before
their last: what is held is a piece or two, however long the file.

The format: https://mcap.dev/spec
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import suppress
import heapq
from pathlib import Path
import struct
from typing import NamedTuple
from zlib import crc32

from blob_tracker.ros.bags.compression import decompressed, DECOMPRESSION_FAULTS
from blob_tracker.ros.bags.qos import profiles
from blob_tracker.ros.bags.topic import CDR, Message, ROS1, todays_kind, Topic

MAGIC = b'\x89MCAP0\r\n'
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, CHUNK_INDEX, STATISTICS, DATA_END = (
    2, 3, 4, 5, 6, 8, 11, 15)
PIECE_BYTES = 1 << 20  # of messages outside of chunks
_RECORD = struct.Struct('<BQ')  # code and length
_FOOTER = struct.Struct('<BQQQI8s')
_MESSAGE = struct.Struct('<HIQQ')  # channel, sequence, log time, publish time
_CHUNK = struct.Struct('<QQQI')  # first and last log time, size, CRC
_COUNT = struct.Struct('<HQ')
_LENGTH = struct.Struct('<I')
_SIZE = struct.Struct('<Q')
_ENCODINGS = {'ros2msg': CDR, 'ros2idl': CDR, 'ros1msg': ROS1}


class _Piece(NamedTuple):
    """What is decompressed at once, by its place in the file."""

    first_ns: int
    last_ns: int
    start: int  # of a chunk's record, or of the first record outside of chunks
    end: int
    chunk: bool
    channels: frozenset[int] | None  # None if only its records tell


class McapFile:
    """An mcap file of any profile; see `BagFile`."""

    def __init__(self, path: Path) -> None:
        self.topics: list[Topic] = []
        self.promised: dict[Topic, int] | None = None
        self.flaws: list[str] = []
        self._channels: dict[int, Topic] = {}
        self._schemas: dict[int, tuple[str, str]] = {}
        self._counts: dict[int, int] = {}
        self._pieces: list[_Piece] = []
        self._size = path.stat().st_size
        self._file = path.open('rb')
        try:
            if not self._indexed():
                self._scan()
        except BaseException:
            self.close()
            raise
        self.topics = list(self._channels.values())

    def counts(self) -> dict[Topic, int]:
        """Return how many messages of each topic are there, or are said to be."""
        found: dict[Topic, int] = {}
        for channel, topic in self._channels.items():
            found[topic] = found.get(topic, 0) + self._counts.get(channel, 0)
        return found

    def span(self) -> tuple[int, int] | None:
        """Return the time of the first message and of the last, ns; None without any."""
        if not self._pieces:
            return None
        return min(each.first_ns for each in self._pieces), max(
            each.last_ns for each in self._pieces)

    def messages(self, topics: Collection[Topic]) -> Iterator[Message]:
        """Yield the messages of topics in the order of their times."""
        wanted = {channel for channel, topic in self._channels.items() if topic in topics}
        pieces = sorted(
            each for each in self._pieces if each.channels is None or each.channels & wanted)
        waiting: list[tuple[int, int, int, bytes]] = []
        order = 0  # of messages of the same time
        for piece in pieces:
            while waiting and waiting[0][0] <= piece.first_ns:
                yield self._message(heapq.heappop(waiting))
            raw = self._raw(piece)
            for code, start, end in _records(raw):
                if code == MESSAGE and end - start >= _MESSAGE.size:
                    channel, _, log_ns, _ = _MESSAGE.unpack_from(raw, start)
                    if channel in wanted:
                        order += 1
                        data = raw[start + _MESSAGE.size:end]
                        heapq.heappush(waiting, (log_ns, order, channel, data))
        while waiting:
            yield self._message(heapq.heappop(waiting))

    def close(self) -> None:
        """Close it."""
        self._file.close()

    def _message(self, entry: tuple[int, int, int, bytes]) -> Message:
        log_ns, _, channel, data = entry
        return Message(self._channels[channel], log_ns, data)

    def _indexed(self) -> bool:
        """Read the index at the end; tell whether it is there and has all that it speaks of."""
        begin = self._size - _FOOTER.size
        if begin < len(MAGIC):
            return False
        self._file.seek(begin)
        code, length, summary, _, _, magic = _FOOTER.unpack(self._file.read(_FOOTER.size))
        if (code, length, magic) != (FOOTER, 20, MAGIC) or not len(MAGIC) <= summary < begin:
            return False
        self._file.seek(summary)
        content = self._file.read(begin - summary)
        statistics: tuple[int, int, dict[int, int]] | None = None
        try:
            for code, start, end in _records(content):
                body = content[start:end]
                if code in (SCHEMA, CHANNEL):
                    self._learn(code, body)
                elif code == CHUNK_INDEX:
                    self._pieces.append(_of_index(body))
                elif code == STATISTICS:
                    statistics = _statistics(body)
        except struct.error:
            statistics = None
        if statistics is not None:
            total, chunks, self._counts = statistics
            if (
                total == sum(self._counts.values()) and chunks == len(self._pieces)
                and (chunks or not total)
                and all(count == 0 or each in self._channels
                        for each, count in self._counts.items())
                and all(each.end <= self._size for each in self._pieces)
            ):
                self._pieces = [each for each in self._pieces if each.last_ns]
                self.promised = self.counts()
                return True
        self._pieces = []
        return False

    def _scan(self) -> None:
        """Look at all records: find pieces, topics and counts, up to the last whole one."""
        promised, self._counts = self._counts, {}
        place = len(MAGIC)
        loose: _Piece | None = None  # that grows
        while True:
            self._file.seek(place)
            head = self._file.read(_RECORD.size)
            if len(head) < _RECORD.size:
                # Whoever is killed between two records leaves no flaw but that.
                self.flaws.append('it has no end')
                break
            code, length = _RECORD.unpack(head)
            end = place + _RECORD.size + length
            whole = end <= self._size
            if code in (FOOTER, DATA_END) and whole:
                break
            if code == 0:
                self.flaws.append(f'it is damaged at byte {place}')
                break
            if code == CHUNK:
                self._add_chunk(_Piece(0, 0, place, min(end, self._size), True, None))
            elif whole and code == MESSAGE and length >= _MESSAGE.size:
                channel, _, log_ns, _ = _MESSAGE.unpack(self._file.read(_MESSAGE.size))
                self._counts[channel] = self._counts.get(channel, 0) + 1
                loose = _grown(loose, log_ns, place, end)
                if self._pieces and self._pieces[-1].start == loose.start:
                    self._pieces[-1] = loose
                else:
                    self._pieces.append(loose)
            elif whole and code in (SCHEMA, CHANNEL):
                self._learn(code, self._file.read(length))
            if not whole:
                self.flaws.append('it ends in the middle of a record')
                break
            place = end
        unknown = self._counts.keys() - self._channels.keys()
        if unknown:
            self.flaws.append(f'{sum(self._counts.pop(each) for each in unknown)} of its messages '
                              'are of topics that it does not name')
        if promised:
            self.promised = {
                self._channels[each]: count for each, count in promised.items()
                if each in self._channels
            }

    def _add_chunk(self, piece: _Piece) -> None:
        """Add a chunk, with what its records tell."""
        raw = self._raw(piece)
        times = []
        for code, start, end in _records(raw):
            if code in (SCHEMA, CHANNEL):
                self._learn(code, raw[start:end])
            elif code == MESSAGE and end - start >= _MESSAGE.size:
                channel, _, log_ns, _ = _MESSAGE.unpack_from(raw, start)
                self._counts[channel] = self._counts.get(channel, 0) + 1
                times.append(log_ns)
        if times:
            self._pieces.append(piece._replace(first_ns=min(times), last_ns=max(times)))

    def _raw(self, piece: _Piece) -> bytes:
        """Return the records of a piece; of a chunk that was cut, those that are there."""
        self._file.seek(piece.start)
        if not piece.chunk:
            return self._file.read(piece.end - piece.start)
        try:
            _, length = _RECORD.unpack(self._file.read(_RECORD.size))
            _, _, size, crc = _CHUNK.unpack(self._file.read(_CHUNK.size))
            (letters,) = _LENGTH.unpack(self._file.read(_LENGTH.size))
            compression = self._file.read(letters).decode(errors='replace')
            (stored,) = _SIZE.unpack(self._file.read(_SIZE.size))
            raw = decompressed(self._file.read(min(stored, self._size)), compression)
        except DECOMPRESSION_FAULTS:
            self._flawed(f'its chunk at byte {piece.start} cannot be decompressed')
            return b''
        whole = piece.start + _RECORD.size + length <= self._size
        if whole and (len(raw) != size or (crc and crc32(raw) != crc)):
            self._flawed(f'its chunk at byte {piece.start} is damaged')
            return b''
        return raw

    def _flawed(self, flaw: str) -> None:
        if flaw not in self.flaws:
            self.flaws.append(flaw)

    def _learn(self, code: int, body: bytes) -> None:
        """Read what a schema or a channel is; one that is damaged names no topic."""
        with suppress(struct.error):
            self._learn_whole(code, body)

    def _learn_whole(self, code: int, body: bytes) -> None:
        (number,) = struct.unpack_from('<H', body)
        if code == SCHEMA:
            name, place = _text(body, 2)
            encoding, _ = _text(body, place)
            self._schemas[number] = name, encoding
            return
        (schema,) = struct.unpack_from('<H', body, 2)
        kind, schema_encoding = self._schemas.get(schema, ('', ''))
        name, place = _text(body, 4)
        encoding, place = _text(body, place)
        (length,) = struct.unpack_from('<I', body, place)
        entries = _entries(body[place + 4:place + 4 + length])
        encoding = encoding or _ENCODINGS.get(schema_encoding, '')
        self._channels.setdefault(number, Topic(
            name, todays_kind(kind), encoding, profiles(entries.get('offered_qos_profiles'))))


def _records(raw: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield code, start and end of each whole record."""
    place, size = 0, len(raw)
    while place + _RECORD.size <= size:
        code, length = _RECORD.unpack_from(raw, place)
        start = place + _RECORD.size
        place = start + length
        if place > size:
            return
        yield code, start, place


def _text(content: bytes, place: int) -> tuple[str, int]:
    """Return a text, and the place after it."""
    (length,) = struct.unpack_from('<I', content, place)
    end = place + 4 + length
    return content[place + 4:end].decode(errors='replace'), end


def _entries(content: bytes) -> dict[str, str]:
    """Return what a channel's metadata name."""
    found, place = {}, 0
    while place < len(content):
        key, place = _text(content, place)
        found[key], place = _text(content, place)
    return found


def _of_index(body: bytes) -> _Piece:
    """Return the chunk that an entry of the index speaks of."""
    first_ns, last_ns, start, length, offsets = struct.unpack_from('<QQQQI', body)
    channels = frozenset(
        channel for channel, _ in _COUNT.iter_unpack(body[36:36 + offsets]))
    return _Piece(first_ns, last_ns, start, start + length, True, channels or None)


def _statistics(body: bytes) -> tuple[int, int, dict[int, int]]:
    """Return the numbers of messages and of chunks, and the messages of each channel."""
    total, _, _, _, _, chunks, _, _, length = struct.unpack_from('<QHIIIIQQI', body)
    return total, chunks, dict(_COUNT.iter_unpack(body[46:46 + length]))


def _grown(piece: _Piece | None, log_ns: int, start: int, end: int) -> _Piece:
    """Return a piece with one more message outside of chunks, or the next where it is full."""
    if piece is None or start - piece.start > PIECE_BYTES or start != piece.end:
        return _Piece(log_ns, log_ns, start, end, False, None)
    return piece._replace(
        first_ns=min(piece.first_ns, log_ns), last_ns=max(piece.last_ns, log_ns), end=end)
