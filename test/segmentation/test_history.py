"""Frames are kept in order; what cannot follow is named."""

from blob_tracker.segmentation.history import FrameError, FrameHistory
from blob_tracker.types import Frame
import numpy as np
import pytest

IMAGE = np.zeros((4, 6), dtype=np.uint8)
MS = 1_000_000


def test_the_last_frames_are_kept() -> None:
    """As many as asked for, and the interval comes back."""
    history = FrameHistory(2, 0.1)
    assert history.push(Frame(IMAGE, 0, 255)) is None
    assert history.push(Frame(IMAGE, 20 * MS, 255)) == pytest.approx(0.02)
    history.push(Frame(IMAGE, 40 * MS, 255))
    assert [frame.stamp_ns for frame in history.frames] == [20 * MS, 40 * MS]


def test_a_gap_forgets_what_was_before() -> None:
    """The interval is told, and only the new frame is left."""
    history = FrameHistory(3, 0.1)
    history.push(Frame(IMAGE, 0, 255))
    assert history.push(Frame(IMAGE, 150 * MS, 255)) == pytest.approx(0.15)
    assert [frame.stamp_ns for frame in history.frames] == [150 * MS]


def test_frames_that_nobody_stamps_are_told() -> None:
    """The first of them may be the beginning of time."""
    history = FrameHistory(3, 0.1)
    history.push(Frame(IMAGE, 0, 255))
    with pytest.raises(FrameError, match='its stamp is 0 like that before: whoever takes the im'):
        history.push(Frame(IMAGE, 0, 255))


@pytest.mark.parametrize('frame, sentence, kept', [
    (Frame(IMAGE, 1000 * MS, 255), 'its stamp is repeated', 1000 * MS),
    (Frame(IMAGE, 990 * MS, 255), '0.010 s older than the one before', 1000 * MS),
    (Frame(IMAGE, 500 * MS, 255), 'jumped back by 0.500 s', 500 * MS),
    (
        Frame(IMAGE[:3], 1010 * MS, 255),
        r'^the frames changed from 6 x 4 px \(uint8\) to 6 x 3 px \(uint8\);', 1010 * MS,
    ),
    (Frame(IMAGE, 1010 * MS, 255, x0=8), r'from .* at \(0, 0\) to .* at \(8, 0\);', 1010 * MS),
    (
        Frame(IMAGE, 1010 * MS, 255, binning=(2, 2)), 'from .* binned 1 x 1 to .* binned 2 x 2;',
        1010 * MS,
    ),
    (Frame(IMAGE.astype(np.uint16), 1010 * MS, 255), r'to 6 x 4 px \(uint16\);', 1010 * MS),
])
def test_what_cannot_follow_is_refused(frame: Frame, sentence: str, kept: int) -> None:
    """Late frames are left out; a change or a jump back starts afresh with the new frame."""
    history = FrameHistory(3, 0.1)
    history.push(Frame(IMAGE, 1000 * MS, 255))
    with pytest.raises(FrameError, match=sentence):
        history.push(frame)
    assert [each.stamp_ns for each in history.frames] == [kept]


def test_the_longest_interval_follows_the_frame_rate() -> None:
    """A camera of 4 Hz is known after three intervals; a lost frame and a pause still part."""
    history = FrameHistory(2, 0.0)
    stamps = [*range(0, 2000, 250), 2250, 7250, *range(7500, 9000, 250)]
    kept = []
    for stamp in stamps:
        history.push(Frame(IMAGE, (stamp + 10_000) * MS, 255))
        kept.append(len(history.frames))
    assert kept == [1, 1, 1, *[2] * 5, 1, 1, *[2] * 6]
    assert history.max_interval == pytest.approx(0.375)


def test_a_fast_camera_may_lose_frames() -> None:
    """0.1 s, as ever; and what is set holds for a slow one."""
    history = FrameHistory(2, 0.0)
    for stamp in (0, 16, 33, 50, 67, 150):
        history.push(Frame(IMAGE, (stamp + 1000) * MS, 255))
    assert len(history.frames) == 2
    assert history.max_interval == 0.1
    slow = FrameHistory(2, 0.05)
    for stamp in range(0, 2000, 200):
        slow.push(Frame(IMAGE, (stamp + 1000) * MS, 255))
    assert len(slow.frames) == 1
