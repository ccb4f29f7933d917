"""The loops over pixels of this room, compiled before the first frame needs them."""

from __future__ import annotations

from blob_tracker.segmentation.at_once import Asked, is_survey, Watched
from blob_tracker.segmentation.black_core import without_black_cores
from blob_tracker.segmentation.blink import compile_blinking
from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.candidates import table_of
from blob_tracker.segmentation.chance import advance, FIELDS
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.crowd import Crowd
from blob_tracker.segmentation.drift import light_at
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.flash_memory import FlashMemory
from blob_tracker.segmentation.flash_track import FlashTrack
from blob_tracker.segmentation.flash_watch import exposure_of, FlashWatch
from blob_tracker.segmentation.flat_top import compile_flat_top
from blob_tracker.segmentation.frame_stack import FrameStack
from blob_tracker.segmentation.illumination import relit
from blob_tracker.segmentation.repeated_frames import RepeatedFrames
from blob_tracker.segmentation.search import NO_MASK, search
from blob_tracker.segmentation.sigma_window import sigma_window
from blob_tracker.segmentation.steady import strongest
from blob_tracker.types import Frame
import numpy as np


def compile_ahead() -> None:
    """Compile them, or load them from Numba's cache."""
    for kind in (np.uint8, np.uint16):
        unlit = np.zeros((16, 16), kind)
        lit = unlit.copy()
        lit[7:10, 7:10] = 100
        frame = Frame(lit, 0, 255)
        contrast = Contrast(lit, unlit, 255, frame, (lit,), (unlit,))
        candidates = search(contrast, Box(0, 0, 16, 16), min_snr=7.0).candidates
        without_black_cores(contrast, candidates)
        light = candidates[strongest(table_of(candidates), 0.0)]
        relit(unlit, np.ones((1, 2)), 255)
        light_at(lit, 8.0, 8.0, 1.0)
        FlashWatch().add(lit, unlit, light, (8.0, 8.0), (1.0, 1.0, 0.5, 0.5))
        window = sigma_window(contrast, light, 8, sigmas=3.0)
        assert window is not None
        FrameStack(1).add('', contrast, light, window)
        FlashMemory(8.0).at_once(
            0, lit, unlit, Asked(NO_MASK, 7.0, 6.0, 3.0, 8), 255, Crowd(8.0).values,
            Watched(FlashWatch().memory, (8.0, 8.0), 1.0, 0.0), alone=True,
        )
        repeated = RepeatedFrames()
        repeated.push(frame)
        repeated.push(Frame(unlit, 1, 255))
    _compile_confirmation(light)
    advance(np.empty((0, FIELDS)), np.empty((0, 7)), np.empty((0, 6)), 0.0, 1.0)
    is_survey(0)
    exposure_of(0.0, 1.0)
    compile_blinking()
    compile_flat_top()


def _compile_confirmation(light: Candidate) -> None:
    """Have a light and one beside it flash, and be expected, agreed on, hidden and found again."""
    shape = 64, 64
    memory, crowd = FlashMemory(8.0), Crowd(8.0)
    for index in range(2):
        memory.next_frame(2 * index)
        memory.region(shape)
        seen, _, _ = memory.see([light], crowd.values, shape, alone=True, agreed=index == 0)
        memory.confirm(seen, crowd.values, shape, alone=True)
        memory.among(seen)
        memory.keep(seen, 0)
    memory.expect(Expectation(light.x, light.y, np.eye(2)))
    memory.half_side()
    memory.is_missed([light])
    memory.companions.learn(FlashTrack(0.0, 0.0, 1.0, 1.0, 0.0), [
        FlashTrack(30.0, 0.0, 1.0, 1.0, 0.0)
    ])
    memory.why_to_wait(light)
    memory.why_another(light)
    memory.survey([light])
    memory.keep_alone(memory.followed)
    crowd.add(0.0, 0)
    crowd.add_part(0.0, 0)
    crowd.is_dense(shape, 1.0)
    crowd.is_beside(shape, 1.0)
