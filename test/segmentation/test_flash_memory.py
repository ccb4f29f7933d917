"""The target is known from what flashes beside it, also while it is hidden."""

from __future__ import annotations

from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.crowd import Crowd
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.flash_memory import FlashMemory, PATIENCE_FRAMES
import numpy as np
from support.contrasts import candidate_at

SHAPE = (480, 640)
STEP_NS = 16_666_667
TARGET, REFLECTION = candidate_at(200, 100), candidate_at(240, 100, height=60.0, snr=60.0)


def see(memory: FlashMemory, index: int, *lights: Candidate) -> Candidate | None:
    """Take a frame; return what is followed in it."""
    memory.next_frame(10**18 + index * STEP_NS)
    seen, best, _ = memory.see(lights, Crowd(24.0).values, SHAPE, alone=True, agreed=False)
    return None if best < 0 else lights[int(seen[best, -3])]


def followed_beside_a_reflection() -> FlashMemory:
    """Return the memory of a target that has flashed five times beside its reflection."""
    memory = FlashMemory(24.0)
    for index in range(0, 10, 2):
        see(memory, index, TARGET)
        memory.survey([REFLECTION])
        see(memory, index + 1)
    return memory


def test_a_light_beside_the_target_is_known_by_where_it_is() -> None:
    """It flashes with it, is learned, and is not taken for it for a second."""
    memory = followed_beside_a_reflection()
    see(memory, 10, TARGET)
    memory.survey([REFLECTION])
    beside, = memory.in_run(3)
    assert (beside.x, beside.flashes) == (240.0, 6.0)
    memory.learn([beside])
    assert memory.beside(REFLECTION) == 0 and memory.beside(TARGET) == -1
    assert 'another light flashes in step, 40 px' in memory.why_to_wait(REFLECTION)
    assert memory.why_to_wait(TARGET) == ''
    for index in range(11, 12 + PATIENCE_FRAMES):
        memory.next_frame(10**18 + index * STEP_NS)
    assert not memory.locked and memory.why_to_wait(REFLECTION) == ''


def test_what_is_followed_in_its_place_leaves_it_the_target() -> None:
    """A light beside it that is met once it is gone stands in for it."""
    memory = followed_beside_a_reflection()
    see(memory, 10, TARGET)
    memory.survey([REFLECTION])
    memory.learn(memory.in_run(3))
    for index in range(11, 80):
        memory.next_frame(10**18 + index * STEP_NS)
    memory.next_frame(10**18 + 80 * STEP_NS)
    seen, _, _ = memory.see(
        [REFLECTION], Crowd(24.0).values, SHAPE, alone=True, agreed=False
    )
    memory.keep(seen, 0)
    assert memory.stands_in
    followed = memory.followed
    assert followed is not None and followed.x == 240.0


def test_a_brighter_light_is_exchanged_for_it() -> None:
    """What was followed is its reflection then."""
    memory = FlashMemory(24.0)
    for index in range(0, 8, 2):
        see(memory, index, REFLECTION)
        memory.survey([TARGET])
        if index < 6:
            see(memory, index + 1)
    brighter, = memory.in_run(3)
    memory.exchange(brighter)
    assert memory.followed == brighter and not memory.stands_in


def test_an_expectation_holds_for_its_frame() -> None:
    """The region lies about it, and in the next frame about the prediction."""
    memory = followed_beside_a_reflection()
    memory.next_frame(10**18 + 10 * STEP_NS)
    memory.expect(Expectation(300.0, 200.0, np.eye(2)))
    region = memory.region(SHAPE)
    assert ((region.x0 + region.x1) // 2, (region.y0 + region.y1) // 2) == (300, 200)
    assert memory.is_missed([TARGET]) and not memory.is_missed([candidate_at(301, 200)])
    memory.next_frame(10**18 + 11 * STEP_NS)
    region = memory.region(SHAPE)
    assert ((region.x0 + region.x1) // 2, (region.y0 + region.y1) // 2) == (200, 100)
