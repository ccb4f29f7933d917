"""What a segmenter saw last, of frames that follow too fast to look at each."""

from __future__ import annotations

from blob_tracker.nodes.segmenter.last_detections import LastDetections, PAUSE_NS
from blob_tracker.segmentation import FieldSegmenter, Segmenter
from blob_tracker.simulation import flashing_light
from blob_tracker.types import Frame

FRAMES = 60
STEP_NS = 2_000_000  # ns from frame to frame


def test_frames_with_and_without_a_light_are_looked_at_in_turns() -> None:
    """One of each in a pause, whichever of them it is that begins it."""
    scene = flashing_light(width=160, height=120)
    segmenter, last = FieldSegmenter(Segmenter), LastDetections()
    looked = []
    for index in range(FRAMES):
        segmenter.update(Frame(scene.frame(index), index * STEP_NS, saturation=255))
        found = last.update(segmenter, index * STEP_NS)
        if found is not None:
            assert list(found.windows) == list(segmenter.in_view)
            looked.append((index * STEP_NS, bool(found.windows)))
    for kind in (True, False):
        times = [at_ns for at_ns, seen in looked if seen is kind]
        assert len(times) >= 3
        # A frame of the other kind lies between two of one.
        assert all(
            PAUSE_NS <= after - before <= PAUSE_NS + 2 * STEP_NS
            for before, after in zip(times[1:], times[2:])
        )


def test_what_was_seen_before_is_not_seen_again() -> None:
    """A frame that is left out leaves what there was; and the next one is looked at."""
    scene = flashing_light(width=160, height=120)
    segmenter, last = FieldSegmenter(Segmenter), LastDetections()
    for index in range(9):
        segmenter.update(Frame(scene.frame(index), index * STEP_NS, saturation=255))
    assert last.update(segmenter, 0) is segmenter.detections
    assert list(segmenter.in_view) == ['']
    segmenter.update(Frame(scene.frame(8), 9 * STEP_NS, saturation=255))
    assert segmenter.repeated_frames == 1
    assert not segmenter.in_view
    assert last.update(segmenter, PAUSE_NS) is None
    segmenter.update(Frame(scene.frame(9), 10 * STEP_NS, saturation=255))
    assert last.update(segmenter, PAUSE_NS) is segmenter.detections
