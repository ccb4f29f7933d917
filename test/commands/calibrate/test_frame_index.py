"""Which frames show what light, by an index and by descriptors as other programs write them."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.calibration.frame_pair import PhotonTransferError
from blob_tracker.commands.calibrate.frame_index import find_index, Light, read_index
import pytest

DESCRIPTOR = """# a comment
v 3.0
n 12 640 480
b 40000.0 120.5
i images\\b_1.png
i images\\b_2.png
d 40000.0
i images\\d 1.png
i images/d_2.png
"""


def folder(path: Path, name: str, text: str) -> Path:
    """Write an index, and the files of `DESCRIPTOR`; return the folder."""
    (path / 'images').mkdir()
    for each in ('b_1', 'b_2', 'd 1', 'd_2'):
        (path / 'images' / f'{each}.png').touch()
    (path / name).write_text(text)
    return path


def test_a_descriptor_of_emva_1288(tmp_path: Path) -> None:
    """Paths of Windows, a blank in a name, files in a subfolder; whatever its name is."""
    index = find_index(folder(tmp_path, 'EMVA1288_Data.txt', DESCRIPTOR))
    assert index is not None
    bright, dark = Light('bright', 40000.0, 120.5), Light('dark', 40000.0)
    assert read_index(index) == {
        tmp_path / 'images' / 'b_1.png': bright, tmp_path / 'images' / 'b_2.png': bright,
        tmp_path / 'images' / 'd 1.png': dark, tmp_path / 'images' / 'd_2.png': dark,
    }


def test_release_4_and_decimal_commas(tmp_path: Path) -> None:
    """What is not known (`v 4.0`, further commands) is passed over."""
    text = DESCRIPTOR.replace('v 3.0', 'v 4.0\nx 1 2').replace('120.5', '120,5')
    lights = read_index(folder(tmp_path, 'set.txt', text) / 'set.txt')
    assert [light.photons for light in lights.values()] == [120.5, 120.5, None, None]


def test_an_index_may_name_subfolders(tmp_path: Path) -> None:
    """And comes before a descriptor."""
    folder(tmp_path, 'set.txt', DESCRIPTOR)
    (tmp_path / 'index.csv').write_text('file,kind,exposure_ns\nimages/b_1.png,bright,40000\n')
    index = find_index(tmp_path)
    assert index is not None
    assert read_index(index) == {tmp_path / 'images' / 'b_1.png': Light('bright', 40000.0)}


def test_other_texts_are_no_descriptor(tmp_path: Path) -> None:
    """A folder of frames often has notes beside them."""
    assert find_index(folder(tmp_path, 'notes.txt', 'i took these\non Monday\n')) is None


@pytest.mark.parametrize(
    'before, after, sentence',
    [
        ('b 40000.0 120.5', 'b bright 120.5', "line 4: in 'b bright 120.5' 'bright' must be"),
        ('b 40000.0 120.5', 'b', "line 4: 'b' must have the exposure in ns"),
        ('b 40000.0 120.5\n', '', 'line 4: an image before the first b or d'),
        ('d_2', 'd_3', 'names d_3.png, which is not in the folder'),
    ],
)
def test_mistakes_are_one_sentence(
    tmp_path: Path, before: str, after: str, sentence: str
) -> None:
    """The file, the line and what must be there."""
    folder(tmp_path, 'set.txt', DESCRIPTOR.replace(before, after))
    with pytest.raises(PhotonTransferError, match=sentence):
        read_index(tmp_path / 'set.txt')


def test_two_descriptors_are_told_of(tmp_path: Path) -> None:
    """Which of them is meant cannot be known."""
    folder(tmp_path, 'a.txt', DESCRIPTOR)
    (tmp_path / 'b.txt').write_text(DESCRIPTOR)
    with pytest.raises(PhotonTransferError, match='a.txt and b.txt: leave one'):
        find_index(tmp_path)
