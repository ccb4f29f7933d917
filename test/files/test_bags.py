"""Bags of other people: whole, killed, damaged, strange. Each is made here, its images known."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
import shutil
import sqlite3

from blob_tracker.__main__ import main
from blob_tracker.ros.bags import is_bag, opened, RecordingError
from blob_tracker.ros.endpoints.recording import recorded_count
import cv2
from mcap.writer import CompressionType, IndexType
import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionMode, StoragePlugin, Writer
from support.bags import (
    COMPRESSED, compressed, COUNT, HEIGHT, image, KIND, pixels, recorded_pixels, stamp_ns,
    START_NS, STEP_NS, TOPIC, TYPES, WIDTH, write_mcap, write_rosbag1, write_rosbag2,
)
import yaml

MCAP, SQLITE3 = StoragePlugin.MCAP, StoragePlugin.SQLITE3


def assert_images(bag: Path, count: int = COUNT, *, warned: str = '') -> None:
    """Hold the first images of a bag against what was written, and its warnings, if any."""
    assert is_bag(bag)
    remarks: list[str] = []
    found = list(recorded_pixels(bag, warn=remarks.append))
    for index, (seconds, each) in enumerate(found):
        assert seconds == pytest.approx(index * STEP_NS / 1e9, abs=1e-9)
        np.testing.assert_array_equal(each, pixels(index))
    assert len(found) == count
    with opened(bag) as recording:
        assert recorded_count(recording) == count
    if warned:
        (remark,) = remarks
        assert warned in remark
        assert f'{count} messages of {(count - 1) * STEP_NS / 1e9:.3f} s are there' in remark
    else:
        assert not remarks


def cut(file: Path, share: float) -> Path:
    """Leave the first part of a file."""
    content = file.read_bytes()
    file.write_bytes(content[:int(share * len(content))])
    return file


def without_metadata(folder: Path) -> Path:
    """Take away what a killed recorder does not write."""
    (folder / 'metadata.yaml').unlink()
    return folder


def edit_metadata(folder: Path, change: Callable[[dict], object]) -> None:
    """Change metadata.yaml by hand."""
    path = folder / 'metadata.yaml'
    content = yaml.safe_load(path.read_text())
    change(content['rosbag2_bagfile_information'])
    path.write_text(yaml.safe_dump(content))


@pytest.mark.parametrize(('storage', 'compression'), [
    *((MCAP, each) for each in CompressionMode),
    # It has no compression of its own.
    *((SQLITE3, each) for each in CompressionMode if each != CompressionMode.STORAGE),
])
def test_whole_bags(storage: StoragePlugin, compression: CompressionMode, tmp_path: Path) -> None:
    """Of the folder, and of its file alone, which then has to tell how it is compressed."""
    file = write_rosbag2(tmp_path / 'bag', storage, compression=compression)
    assert_images(tmp_path / 'bag')
    assert_images(file)


@pytest.mark.parametrize('compression', list(CompressionType))
@pytest.mark.parametrize('indexes', [IndexType.ALL, IndexType.CHUNK, IndexType.NONE])
@pytest.mark.parametrize('statistics', [True, False])
def test_mcap_with_and_without_indexes(
    compression: CompressionType, indexes: IndexType, statistics: bool, tmp_path: Path
) -> None:
    """Each compression; what the index lacks is looked for."""
    assert_images(write_mcap(
        tmp_path / 'a.mcap', compression=compression, indexes=indexes, statistics=statistics))


@pytest.mark.parametrize('chunking', [True, False])
@pytest.mark.parametrize('repeat', [True, False])
def test_messages_out_of_order(chunking: bool, repeat: bool, tmp_path: Path) -> None:
    """They are put in order, those of different chunks too."""
    order = np.random.default_rng(5).permutation(COUNT).tolist()
    path = write_mcap(tmp_path / 'a.mcap', chunking=chunking, order=order, repeat=repeat)
    assert_images(path)


@pytest.mark.parametrize('chunking', [True, False])
def test_topics_that_cannot_be_parsed_shut_nobody_out(chunking: bool, tmp_path: Path) -> None:
    """Definitions of other systems, broken ones, none."""
    path = write_mcap(tmp_path / 'a.mcap', others=True, chunking=chunking)
    assert_images(path)
    with opened(path) as bag:
        assert len(bag.topics) == 8
        assert sum(1 for _ in bag.messages(bag.topics)) == 8 * COUNT


@pytest.mark.parametrize('compression', list(CompressionType))
@pytest.mark.parametrize('chunking', [True, False])
@pytest.mark.parametrize('share', [0.98, 0.6, 0.333])
def test_killed_recorder_of_mcap(
    compression: CompressionType, chunking: bool, share: float, tmp_path: Path
) -> None:
    """All up to the last whole message, from a chunk that was cut as well."""
    (tmp_path / 'bag').mkdir()
    path = write_mcap(
        tmp_path / 'bag' / 'bag_0.mcap', compression=compression, chunking=chunking,
        chunk_size=30000)
    whole = path.read_bytes()
    cut(path, share)
    # An uncompressed image stands in the file as it is; zstd and lz4 hold back at most a block.
    stored = [whole.find(pixels(index).tobytes()) for index in range(COUNT)]
    size = len(path.read_bytes())
    there = sum(1 for place in stored if 0 <= place <= size - WIDTH * HEIGHT)
    remarks: list[str] = []
    found = list(recorded_pixels(path.parent, warn=remarks.append))
    for index, (_, each) in enumerate(found):
        np.testing.assert_array_equal(each, pixels(index))
    if not chunking or compression == CompressionType.NONE:
        assert len(found) == there
    else:
        assert len(found) >= int(share * COUNT) - 30000 // (WIDTH * HEIGHT)
    assert 'it has no metadata.yaml; it ' in remarks[0]
    assert f'. {len(found)} messages of {(len(found) - 1) * STEP_NS / 1e9:.3f} s' in remarks[0]


@pytest.mark.parametrize('tail', [b'', bytes(5000)])
def test_killed_between_two_records(tail: bytes, tmp_path: Path) -> None:
    """All 59 are there; the blocks that a file system had reserved are no messages."""
    path = write_mcap(tmp_path / 'a.mcap', chunking=False)
    content = path.read_bytes()
    # Of the last message to its end: what follows begins with the end of the data.
    end = content.rfind(pixels(COUNT - 1).tobytes()) + WIDTH * HEIGHT
    path.write_bytes(content[:end] + tail)
    assert_images(path, warned='it is damaged at byte' if tail else 'it has no end')


@pytest.mark.parametrize('storage', [MCAP, SQLITE3])
@pytest.mark.parametrize('said', [
    None, '', '{', 'rosbag2_bagfile_information:\n  version: 9\n', "- '", 'unfinished',
])
def test_metadata_that_was_not_written(
    storage: StoragePlugin, said: str | None, tmp_path: Path
) -> None:
    """The bag is opened by its files, with a warning."""
    bag = tmp_path / 'bag'
    write_rosbag2(bag, storage)
    if said is None:
        without_metadata(bag)
    elif said == 'unfinished':  # as Jazzy's recorder writes it at its start
        edit_metadata(bag, lambda content: content.update(
            storage_identifier='', relative_file_paths=[], message_count=0,
            topics_with_message_count=[]))
    else:
        (bag / 'metadata.yaml').write_text(said)
    assert_images(bag, warned='metadata.yaml')


def test_split_bags_come_in_order(tmp_path: Path) -> None:
    """Without metadata too: file 10 after file 9, whatever their order in the folder."""
    for number in range(11):
        write_mcap(tmp_path / f'bag_{number}.mcap', order=range(5 * number, 5 * number + 5))
    assert_images(tmp_path, 55, warned='it has no metadata.yaml')
    (tmp_path / 'bag_11.mcap').touch()
    assert_images(tmp_path, 55, warned='bag_11.mcap is empty')


@pytest.mark.parametrize('journal', ['wal', 'delete'])
def test_sqlite3_with_its_log(journal: str, tmp_path: Path) -> None:
    """What a killed recorder had not yet written into the file comes too; nothing is changed."""
    bag = tmp_path / 'bag'
    file = write_rosbag2(bag, SQLITE3)
    killed = tmp_path / 'killed'
    with sqlite3.connect(file) as database:
        database.execute(f'PRAGMA journal_mode={journal}')
        database.execute('PRAGMA cache_size=1')  # so that a transaction reaches the file
        if journal == 'wal':
            database.execute('PRAGMA wal_autocheckpoint=0')
            rows = database.execute('SELECT * FROM messages WHERE id > 30').fetchall()
            database.execute('DELETE FROM messages WHERE id > 30')
            database.commit()
            database.execute('PRAGMA wal_checkpoint(TRUNCATE)')
            places = ','.join('?' * len(rows[0]))
            database.executemany(f'INSERT INTO messages VALUES({places})', rows)
            database.commit()
        else:
            database.execute('UPDATE messages SET data = zeroblob(3)')
        shutil.copytree(bag, killed)
        database.rollback()
    for each in killed.glob('*-shm'):
        each.unlink()
    before = sorted(each.name for each in killed.iterdir())
    assert f'bag.db3-{"wal" if journal == "wal" else "journal"}' in before
    assert_images(killed)
    assert_images(killed / 'bag.db3')
    assert sorted(each.name for each in killed.iterdir()) == before
    if journal == 'wal':
        (killed / 'bag.db3-wal').unlink()
        with pytest.raises(RecordingError, match='59 messages are promised and 30 came'):
            assert_images(killed)


def test_qos_may_be_edited(tmp_path: Path) -> None:
    """It does not decide which messages come, only how they are offered again."""
    bag = tmp_path / 'bag'
    write_rosbag2(bag)
    edit_metadata(bag, lambda content: content['topics_with_message_count'][0][
        'topic_metadata']['offered_qos_profiles'][0].update(reliability='best_effort'))
    assert_images(bag)
    with opened(bag) as found:
        (topic,) = found.topics
        assert topic.qos[0]['reliability'] == 'best_effort'


@pytest.mark.parametrize('storage', [MCAP, SQLITE3])
@pytest.mark.parametrize('promised', [58, 60])
def test_other_than_promised_is_said(
    storage: StoragePlugin, promised: int, tmp_path: Path
) -> None:
    """After all that is there has come."""
    bag = tmp_path / 'bag'
    write_rosbag2(bag, storage)
    edit_metadata(bag, lambda content: content['topics_with_message_count'][0].update(
        message_count=promised))
    came = []
    with pytest.raises(RecordingError, match=f'{promised} messages are promised and 59 came'):
        for each in recorded_pixels(bag):
            came.append(each)
    assert len(came) == COUNT


def test_a_damaged_chunk_is_missed(tmp_path: Path) -> None:
    """The others come, and the sum is said to be wrong."""
    path = write_mcap(tmp_path / 'a.mcap', compression=CompressionType.NONE)
    content = bytearray(path.read_bytes())
    content[content.find(pixels(30).tobytes()) + 7] ^= 1
    path.write_bytes(content)
    came = []
    with pytest.raises(RecordingError, match=r'59 messages .* its chunk at byte \d+ is damaged'):
        for each in recorded_pixels(path):
            came.append(each)
    assert COUNT - 10 < len(came) < COUNT


def test_a_database_that_was_cut(tmp_path: Path) -> None:
    """Nothing opens it; the sentence has the command that saves what is left."""
    bag = tmp_path / 'bag'
    cut(write_rosbag2(bag, SQLITE3), 0.6)
    with pytest.raises(RecordingError, match='malformed.*`sqlite3 bag.db3 .recover`'):
        list(recorded_pixels(bag))


def test_a_file_that_is_missing_is_named(tmp_path: Path) -> None:
    """And that it is missed."""
    bag = tmp_path / 'bag'
    write_rosbag2(bag)
    edit_metadata(bag, lambda content: content['relative_file_paths'].append('bag_1.mcap'))
    assert_images(bag, warned='bag_1.mcap, which its metadata.yaml names, is not there')


@pytest.mark.parametrize('compression', [None, *Writer1.CompressionFormat])
def test_bags_of_ros_1(compression: Writer1.CompressionFormat | None, tmp_path: Path) -> None:
    """They are read as they are, a folder of them too."""
    path = write_rosbag1(tmp_path / 'flight.bag', compression)
    assert_images(path)
    assert_images(tmp_path)


def test_a_bag_of_ros_1_becomes_messages_of_ros_2(tmp_path: Path) -> None:
    """To be played."""
    with opened(write_rosbag1(tmp_path / 'flight.bag')) as bag:
        first = next(bag.messages(bag.topics))
        assert bag.serialized(first) == image(0)


RED = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
RED[8:24, 8:40] = 20, 40, 200  # in the order BGR
LUMA = cv2.cvtColor(RED, cv2.COLOR_BGR2GRAY)
YCRCB = cv2.cvtColor(RED, cv2.COLOR_BGR2YCrCb)
NV12 = np.vstack([YCRCB[..., 0], YCRCB[::2, ::2, :0:-1].reshape(HEIGHT // 2, WIDTH)])
YUYV = np.dstack([YCRCB[..., 0], np.where(np.arange(WIDTH) % 2, YCRCB[..., 1], YCRCB[..., 2])])
DEEP = pixels(1).astype(np.uint16) * 200
RGGB = np.where(
    (np.arange(HEIGHT)[:, None] + np.arange(WIDTH)) % 2, RED[..., 1],
    np.where(np.arange(HEIGHT)[:, None] % 2, RED[..., 0], RED[..., 2])).astype(np.uint8)


@pytest.mark.parametrize(('kind', 'data', 'expected', 'close'), [
    (KIND, image(0, RED, 'bgr8'), LUMA, 0),
    (KIND, image(0, RED[..., ::-1].copy(), 'rgb8'), LUMA, 0),
    (KIND, image(0, NV12, 'nv12'), LUMA, 1),
    (KIND, image(0, YUYV, 'yuv422_yuy2'), LUMA, 1),
    (KIND, image(0, DEEP, 'mono16'), DEEP, 0),
    (KIND, image(0, RGGB, 'bayer_rggb8'), LUMA, 3),
    (COMPRESSED, compressed(0, RED, '.png', 'bgr8; png compressed bgr8'), LUMA, 0),
    (COMPRESSED, compressed(0, RED, '.jpg', 'rgb8; jpeg compressed bgr8'), LUMA, 6),
    (COMPRESSED, compressed(0, LUMA, '.jpg', 'jpeg'), LUMA, 6),
    (COMPRESSED, compressed(0, DEEP, '.png', 'mono16; png compressed '), DEEP, 0),
    (COMPRESSED, compressed(0, RGGB, '.png', 'bayer_rggb8; png compressed '), LUMA, 3),
])
def test_images_of_each_kind(
    kind: str, data: bytes, expected: np.ndarray, close: int, tmp_path: Path
) -> None:
    """Compressed, with colours, a mosaic, YUV; a lone topic is taken, whatever its name."""
    bag = tmp_path / 'bag'
    with Writer(bag, version=9, storage_plugin=MCAP) as writer:
        connection = writer.add_connection('/front', kind, typestore=TYPES)
        writer.write(connection, START_NS, data)
    ((seconds, found),) = recorded_pixels(bag)
    assert seconds == 0.0
    assert found.dtype == expected.dtype
    # Within the edge of the red field, where neighbours mix.
    inside = np.s_[10:22, 10:38] if close else np.s_[:]
    assert np.abs(found[inside].astype(int) - expected[inside]).max() <= close


def test_topics_of_images(tmp_path: Path) -> None:
    """A copy that is compressed does not count beside its own; two cameras are named."""
    bag = tmp_path / 'bag'
    with Writer(bag, version=9, storage_plugin=MCAP) as writer:
        raw = writer.add_connection('/left/image', KIND, typestore=TYPES)
        copy = writer.add_connection('/left/image/compressed', COMPRESSED, typestore=TYPES)
        writer.write(raw, stamp_ns(0), image(0))
        writer.write(copy, stamp_ns(0), compressed(0, pixels(9), '.png', 'png'))
    ((_, found),) = recorded_pixels(bag)
    np.testing.assert_array_equal(found, pixels(0))
    ((_, found),) = recorded_pixels(bag, 'left/image/compressed')
    np.testing.assert_array_equal(found, pixels(9))
    with pytest.raises(RecordingError, match='no images on right: set --topic to one of /left/im'):
        next(recorded_pixels(bag, 'right'))
    both = tmp_path / 'both'
    with Writer(both, version=9, storage_plugin=MCAP) as writer:
        for name in ('/left', '/right'):
            writer.write(writer.add_connection(name, KIND, typestore=TYPES), START_NS, image(0))
    with pytest.raises(RecordingError, match='several topics: set --topic to one of /left, /rig'):
        next(recorded_pixels(both))


@pytest.mark.parametrize(('name', 'content', 'sentence'), [
    ('a.mcap', b'', 'is empty'),
    ('a.mcap', b'\x89MCAP0\r\n', 'has no images on any topic'),
    ('a.db3', b'something else', 'is neither mcap nor sqlite3 nor a bag of ROS 1'),
    ('a.db3', b'SQLite format 3\0' + bytes(200), 'is not a readable bag'),
    ('a.bag', b'#ROSBAG V2.0\n', 'is a bag of ROS 1 that is damaged'),
    ('a.mcap.zstd', b'\x28\xb5\x2f\xfd\0\0\0', 'is empty'),
])
def test_what_is_no_bag_is_one_sentence(
    name: str, content: bytes, sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """From a command, which ends with 1 and shows no traceback."""
    path = tmp_path / name
    path.write_bytes(content)
    assert main(['calibrate', 'noise', str(path)]) == 1
    said = capsys.readouterr().err
    assert sentence in said
    assert 'Traceback' not in said


def test_a_killed_bag_of_ros_1_is_to_be_indexed(tmp_path: Path) -> None:
    """With the command that does it."""
    path = write_rosbag1(tmp_path / 'flight.bag')
    content = bytearray(path.read_bytes())
    place = content.find(b'index_pos=') + len(b'index_pos=')
    content[place:place + 8] = bytes(8)
    path.write_bytes(content)
    with pytest.raises(RecordingError, match='no index, its recorder was killed: `rosbag reindex'):
        next(recorded_pixels(path))


def test_a_damaged_message_is_a_sentence(tmp_path: Path) -> None:
    """No traceback of the library that reads it."""
    bag = tmp_path / 'bag'
    with Writer(bag, version=9, storage_plugin=MCAP) as writer:
        connection = writer.add_connection(TOPIC, KIND, typestore=TYPES)
        writer.write(connection, START_NS, image(0)[:40])
    with pytest.raises(RecordingError, match='a message is not a sensor_msgs/msg/Image'):
        next(recorded_pixels(bag))
