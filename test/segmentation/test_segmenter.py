"""The flash is found in any phase, through drops and repeats, and nothing else is."""

from __future__ import annotations

from blob_tracker.segmentation import flash_by_name, FrameError, Segmenter
from blob_tracker.segmentation.alternate import Alternate
from blob_tracker.simulation import flashing_light
from blob_tracker.types import Frame, Window
import numpy as np
import pytest

SCENE = flashing_light(width=160, height=120, period=3.0)
STEP_NS = 16_666_667


def frame(index: int, at: float | None = None) -> Frame:
    """Return a frame of the scene, stamped as if it were the frame `at`."""
    stamp_ns = 10**18 + round(STEP_NS * (index if at is None else at))
    return Frame(SCENE.frame(index), stamp_ns, 255)


def windows(indices: list[int], stamps: list[int] | None = None) -> dict[int, Window]:
    """Feed frames with their own stamps or others; return the windows by their lit frame."""
    segmenter = Segmenter()
    found = {}
    for at, index in zip(stamps or indices, indices, strict=True):
        window = segmenter.update(frame(index, at=at))
        if window is not None:
            assert index not in found
            found[index] = window
    return found


def assert_on_target(found: dict[int, Window]) -> None:
    """Every window holds the light, well inside, with an unlit frame that lacks it."""
    for index, window in found.items():
        truth = SCENE.truth(index)
        height, width = window.lit.shape
        assert truth.lit
        assert abs(truth.x - (window.x0 + (width - 1) / 2)) <= 1.5
        assert abs(truth.y - (window.y0 + (height - 1) / 2)) <= 1.5
        assert int(window.lit.max()) - int(window.unlit.max()) > 0.5 * truth.amplitude


@pytest.mark.parametrize('first', [0, 1])
def test_locks_within_three_frames_in_either_phase(first: int) -> None:
    """Whichever frame comes first, each lit one that follows an unlit one gives a window."""
    found = windows(list(range(first, 40)))
    assert list(found) == list(range(2, 40, 2))
    assert_on_target(found)


def test_window_is_raw_and_in_place() -> None:
    """The pixels are those of the two frames, nothing subtracted."""
    segmenter = Segmenter()
    segmenter.update(frame(1))
    window = segmenter.update(frame(2))
    assert window is not None
    rows = slice(window.y0, window.y0 + window.lit.shape[0])
    columns = slice(window.x0, window.x0 + window.lit.shape[1])
    np.testing.assert_array_equal(window.lit, SCENE.frame(2)[rows, columns])
    np.testing.assert_array_equal(window.unlit, SCENE.frame(1)[rows, columns])
    assert window.stamp_ns == frame(2).stamp_ns
    assert window.saturation == 255


@pytest.mark.parametrize('dropped', [9, 10])
def test_a_dropped_frame_costs_its_own_pair(dropped: int) -> None:
    """Lit or unlit frame lost: no wrong window, and the next pair is found."""
    found = windows([index for index in range(20) if index != dropped])
    assert_on_target(found)
    assert list(found) == [index for index in range(2, 20, 2) if index != 10]


@pytest.mark.parametrize('repeated', [9, 10])
def test_a_frame_that_comes_twice_costs_nothing(repeated: int) -> None:
    """The same picture with a stamp between two others: no window from it, and none lost."""
    indices = sorted([*range(20), repeated])
    stamps = [*range(repeated + 1), repeated + 0.3, *range(repeated + 1, 20)]
    found = windows(indices, stamps)
    assert_on_target(found)
    assert list(found) == list(range(2, 20, 2))


@pytest.mark.parametrize('indices', [
    [index for index in range(30) if index != 9],
    [index for index in range(30) if index != 10],
    sorted([*range(30), 9]),
    sorted([*range(30), 10]),
], ids=['unlit lost', 'lit lost', 'unlit twice', 'lit twice'])
def test_a_slip_that_the_stamps_hide_is_survived(indices: list[int]) -> None:
    """The camera and the light are out of step from there on: locked again at once."""
    found = windows(indices, list(range(len(indices))))
    assert_on_target(found)
    assert [index for index in found if index < 9] == [2, 4, 6, 8]
    assert [index for index in found if index > 14] == list(range(16, 30, 2))


def test_old_and_equal_stamps_are_refused_and_left_out() -> None:
    """The frame is named as the fault, and the sequence goes on as if it had not come."""
    segmenter = Segmenter()
    segmenter.update(frame(0))
    segmenter.update(frame(1))
    with pytest.raises(FrameError, match='its stamp is repeated'):
        segmenter.update(frame(4, at=1))
    with pytest.raises(FrameError, match='older than the one before'):
        segmenter.update(frame(4, at=0))
    assert segmenter.update(frame(2)) is not None


def test_a_jump_back_of_the_clock_starts_afresh() -> None:
    """A bag that begins again is followed at once."""
    segmenter = Segmenter()
    segmenter.update(frame(1, at=1000))
    with pytest.raises(FrameError, match='jumped back by'):
        segmenter.update(frame(1))
    assert segmenter.update(frame(2)) is not None


def test_a_change_of_size_starts_afresh() -> None:
    """Frames of two sizes are never compared."""
    segmenter = Segmenter()
    segmenter.update(frame(0))
    small = Frame(SCENE.frame(1)[:100, :100], 10**18 + STEP_NS, 255)
    with pytest.raises(FrameError, match=r'160 x 120 px \(uint8\) to 100 x 100 px'):
        segmenter.update(small)
    after = Frame(SCENE.frame(2)[:100, :100], 10**18 + 2 * STEP_NS, 255)
    window = segmenter.update(after)  # compared with the small one before it
    assert window is not None, segmenter.reason


def test_a_jump_back_with_another_size_starts_afresh() -> None:
    """A second bag of another camera after the first: nothing of the first is left."""
    big = flashing_light(width=200, height=150, period=3.0)
    segmenter = Segmenter()
    for index in (1, 2):
        segmenter.update(frame(index, at=1000 + index))
    with pytest.raises(FrameError, match='jumped back by'):
        segmenter.update(Frame(big.frame(1), 10**18 + STEP_NS, 255))
    window = segmenter.update(Frame(big.frame(2), 10**18 + 2 * STEP_NS, 255))
    assert window is not None
    truth = big.truth(2)
    assert abs(truth.x - (window.x0 + (window.lit.shape[1] - 1) / 2)) <= 1.5


def test_a_slow_camera_is_followed() -> None:
    """Of 5 Hz: a flash in every other frame, from the first pair on whose rate is known."""
    segmenter = Segmenter(flash=Alternate())
    found = [segmenter.update(frame(index, at=12 * index)) for index in range(16)]
    assert sum(window is not None for window in found) >= 4
    assert 'apart' not in segmenter.reason


def test_pairs_too_far_apart_are_not_compared() -> None:
    """max_pair_interval holds."""
    segmenter = Segmenter(flash=Alternate(max_pair_interval=0.05))
    segmenter.update(frame(1, at=0))
    assert segmenter.update(frame(2, at=4)) is None
    assert 'max_pair_interval' in segmenter.reason


@pytest.mark.parametrize(
    'images, reason',
    [
        ([SCENE.frame(1), SCENE.frame(3)], 'nothing lit up'),
        ([SCENE.frame(2), SCENE.frame(3)], 'nothing lit up'),  # it went out: signed
        ([np.full((120, 160), 40, np.uint8), np.full((120, 160), 60, np.uint8)], 'auto-exposure'),
        ([np.zeros((120, 160), np.uint8)] * 2, 'nothing lit up'),
        ([np.full((120, 160), 255, np.uint8)] * 2, 'nothing lit up'),
        ([np.full((120, 160), 20, np.uint8)] * 2, 'nothing lit up'),
    ],
    ids=['never on', 'goes out', 'exposure jump', 'lens cap', 'all saturated', 'constant'],
)
def test_what_is_no_flash_gives_no_window(images: list[np.ndarray], reason: str) -> None:
    """Light never on or going out, a jump of the exposure, a cap: a reason and no window."""
    segmenter = Segmenter()
    for place, image in enumerate(images):
        window = segmenter.update(Frame(image, 10**18 + place * STEP_NS, 255))
        assert window is None
    assert reason in segmenter.reason


def test_a_light_that_stays_on_and_moves_is_no_flash() -> None:
    """Two lit frames of a moving light leave a rise beside a fall, and no window."""
    moving = flashing_light(width=160, height=120, period=3.0)
    for index in range(0, 120, 2):
        segmenter = Segmenter()
        segmenter.update(Frame(moving.frame(index), 10**18, 255))
        window = segmenter.update(Frame(moving.frame(index + 2), 10**18 + STEP_NS, 255))
        here, there = moving.truth(index), moving.truth(index + 2)
        if np.hypot(here.x - there.x, here.y - there.y) < 2 * 2.5 * here.sigma:
            assert window is None, segmenter.reason


def test_a_target_at_the_edge_is_not_published() -> None:
    """What the frame cuts off cannot be placed."""
    dark = np.full((120, 160), 20, dtype=np.uint8)
    lit = dark.copy()
    lit[50:55, 0:3] = 200
    segmenter = Segmenter()
    segmenter.update(Frame(dark, 10**18, 255))
    assert segmenter.update(Frame(lit, 10**18 + STEP_NS, 255)) is None
    assert 'edge' in segmenter.reason


def test_crop_and_binning_place_the_window_on_the_sensor() -> None:
    """x0 and y0 count sensor pixels."""
    segmenter = Segmenter()
    plain = Segmenter()
    for index in (1, 2):
        stamp_ns = 10**18 + index * STEP_NS
        window = plain.update(Frame(SCENE.frame(index), stamp_ns, 255))
        binned = segmenter.update(
            Frame(SCENE.frame(index), stamp_ns, 255, x0=100, y0=40, binning=(2, 4))
        )
    assert window is not None and binned is not None
    assert (binned.x0, binned.y0) == (100 + 2 * window.x0, 40 + 4 * window.y0)
    assert binned.binning == (2, 4)


def test_unlit_pairs_are_raw_and_hold_no_light() -> None:
    """Once the light is followed, each unlit frame comes with the unlit one before it."""
    segmenter = Segmenter()
    for index in range(20):
        segmenter.update(frame(index))
        pair = segmenter.unlit_pair
        if index >= 6:
            assert (pair is not None) == (index % 2 == 1)
        if index >= 6 and pair is not None:
            np.testing.assert_array_equal(pair[0], SCENE.frame(index - 2))
            np.testing.assert_array_equal(pair[1], SCENE.frame(index))


def test_unlit_pairs_of_a_block_and_across_gaps() -> None:
    """A free-running light gives those of its block; frames far apart are no pair."""
    scene = flashing_light(width=160, height=120, amplitude=0.0)
    lock_in = Segmenter(flash=flash_by_name('lock_in', frequency=15.0, frames=16))
    for index in range(16):
        assert lock_in.unlit_pair is None
        lock_in.update(Frame(scene.frame(index), 10**9 + STEP_NS * index, 255))
    assert lock_in.unlit_pair is not None
    slow = Segmenter()
    for index in range(4):
        slow.update(Frame(scene.frame(index), 10**9 * (1 + 2 * index), 255))
        assert slow.unlit_pair is None
