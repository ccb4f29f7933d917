"""The stamps of a video, of which OpenCV does not tell all."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.commands.sources import grey_frames, SourceError
from blob_tracker.commands.sources.video import open_video
import cv2
import numpy as np
import pytest


class VideoOfTimes:
    """Stands in for OpenCV's reader; its frames have these times, ms."""

    times: tuple[float, ...] = ()
    cut_off = 0

    def __init__(self, _: str) -> None:
        self.read_so_far = 0

    def isOpened(self) -> bool:  # noqa: N802
        """Say that there is a video."""
        return True

    def read(self) -> tuple[bool, np.ndarray]:
        """Return the next frame."""
        self.read_so_far += 1
        return self.read_so_far <= len(self.times), np.zeros((2, 2), dtype=np.uint8)

    def get(self, what: int) -> float:
        """Return the time of the frame that was read, or how many there should be."""
        if what == cv2.CAP_PROP_FRAME_COUNT:
            return len(self.times) + self.cut_off
        return self.times[self.read_so_far - 1]

    def release(self) -> None:
        """Do nothing."""


@pytest.mark.parametrize(('suffix', 'times', 'stamps'), [
    ('.mp4', (0.0, 40.0, 80.0), [0.0, 0.04, 0.08]),
    ('.avi', (0.0, 40.0, 80.0, 0.0, 0.0), [0.0, 0.04, 0.08, 0.12, 0.16]),
    ('.h264', (0.0, 0.0, 0.0), [0.0, None, None]),
])
def test_what_opencv_has_no_time_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str, times: tuple[float, ...],
    stamps: list[float | None],
) -> None:
    """Goes on at the pace of those before; where none has one, none is made up."""
    monkeypatch.setattr(VideoOfTimes, 'times', times)
    monkeypatch.setattr(cv2, 'VideoCapture', VideoOfTimes)
    path = tmp_path / f'light{suffix}'
    path.touch()
    found = [seconds for _, seconds, _, _ in grey_frames(open_video(path))]
    assert found == pytest.approx(stamps)


@pytest.mark.parametrize('suffix', ['.mp4', '.mkv'])
def test_a_video_that_is_cut_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    """After its frames; of a container without a count nobody knows."""
    monkeypatch.setattr(VideoOfTimes, 'times', (0.0, 40.0, 80.0))
    monkeypatch.setattr(VideoOfTimes, 'cut_off', 5)
    monkeypatch.setattr(cv2, 'VideoCapture', VideoOfTimes)
    path = tmp_path / f'light{suffix}'
    path.touch()
    frames = grey_frames(open_video(path))
    assert [next(frames).seconds for _ in range(3)] == [0.0, 0.04, 0.08]
    if suffix == '.mkv':
        assert not list(frames)
    else:
        with pytest.raises(SourceError, match='ends after 3 of 8 frames'):
            next(frames)


@pytest.mark.parametrize('missing', [1, 2])
def test_a_frame_or_two_fewer_than_the_header_has_are_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
    missing: int,
) -> None:
    """As sound files are too: it is no fault."""
    monkeypatch.setattr(VideoOfTimes, 'times', (0.0, 40.0, 80.0))
    monkeypatch.setattr(VideoOfTimes, 'cut_off', missing)
    monkeypatch.setattr(cv2, 'VideoCapture', VideoOfTimes)
    path = tmp_path / 'light.mp4'
    path.touch()
    assert len(list(grey_frames(open_video(path)))) == 3
    said = capsys.readouterr().err
    assert f'has 3 frames that can be read, and {3 + missing} by its header' in said


@pytest.mark.parametrize(
    ('suffix', 'code'), [('.avi', 'MJPG'), ('.mp4', 'mp4v'), ('.mov', 'mp4v')]
)
def test_a_file_that_is_cut(tmp_path: Path, suffix: str, code: str) -> None:
    """An AVI has its frames up to there; MP4 and MOV end with their index, and do not open."""
    path = tmp_path / f'light{suffix}'
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*code), 30.0, (64, 48))
    random = np.random.default_rng(1)
    for _ in range(30):
        writer.write(random.integers(0, 40, (48, 64, 3)).astype(np.uint8))
    writer.release()
    assert len(list(grey_frames(open_video(path)))) == 30
    content = path.read_bytes()
    path.write_bytes(content[:len(content) * 6 // 10])
    if suffix == '.avi':
        frames = grey_frames(open_video(path))
        with pytest.raises(SourceError, match=r'ends after 1[0-9] of 30 frames: it was cut'):
            list(frames)
    else:
        with pytest.raises(SourceError, match='not a video that OpenCV can read: copy it again'):
            open_video(path)


@pytest.mark.parametrize(('suffix', 'code', 'codec'), [
    ('.mp4', 'mp4v', 'MPEG-4'), ('.avi', 'XVID', 'MPEG-4'), ('.avi', 'MJPG', 'JPEG'),
    ('.avi', 'FFV1', ''), ('.mkv', 'FFV1', ''),
])
def test_a_codec_that_loses_detail_is_named(
    suffix: str, code: str, codec: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before it is taken for a fault of the light or the camera."""
    path = tmp_path / f'light{suffix}'
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*code), 30.0, (64, 48))
    writer.write(np.zeros((48, 64, 3), np.uint8))
    writer.release()
    open_video(path)
    said = capsys.readouterr().err
    assert said.startswith(f'{path} is coded as {codec}, which may lose') if codec else not said
