"""Frames of another size, and stamps that jump back, begin afresh in every flash mode."""

from __future__ import annotations

from blob_tracker.segmentation import flash_by_name, FLASH_MODES, FrameError, Segmenter
from blob_tracker.simulation import coded, Light, Scene
from blob_tracker.types import Frame
import pytest

CODE = '1101000'
RATE = 60.0
COUNT = 40  # frames: rounds enough of the code, and two blocks


def frames(width: int, height: int, first: int) -> list[Frame]:
    """Return frames of one coded light near the lower right corner."""
    bits = coded(CODE, 1 / RATE, start=0.5 / RATE)
    scene = Scene(
        elements=[Light(width - 40.3, height - 30.2, 2.0, 120.0, bits)],
        width=width, height=height, rate=RATE, exposure=0.3, texture=0.0,
    )
    return [
        Frame(scene.frame(index), scene.stamp_ns(index), 255)
        for index in range(first, first + COUNT)
    ]


@pytest.mark.parametrize('change', ['smaller', 'larger', 'back'])
@pytest.mark.parametrize('mode', FLASH_MODES)
def test_one_frame_is_refused_and_the_next_ones_are_taken(mode: str, change: str) -> None:
    """What a mode remembers of the frames before has no place in those that follow."""
    segmenter = Segmenter(flash=flash_by_name(mode, codes={'only': CODE}))
    for frame in frames(200, 150, 100):
        segmenter.sightings(frame)
    size = {'smaller': (120, 90), 'larger': (320, 240), 'back': (200, 150)}[change]
    first, *others = frames(*size, 0 if change == 'back' else 100 + COUNT)
    with pytest.raises(FrameError, match='starting again'):
        segmenter.sightings(first)
    found = [bool(segmenter.sightings(frame)) for frame in others]
    # A code is read from anew: what was seen of it before says nothing of these frames.
    assert mode != 'coded' or (any(found) and not any(found[:len(CODE) - 2]))
