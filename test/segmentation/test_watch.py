"""What blinks before a camera is told after some frames, with its place and its height."""

from __future__ import annotations

from blob_tracker.segmentation import FrameError, Segmenter
from blob_tracker.segmentation.watch import Watch
from blob_tracker.simulation import always, coded, Light, periodic, Scene
from blob_tracker.types import Frame
import numpy as np
import pytest

RATE = 60.0


def scene(*lights: Light, texture: float = 0.0) -> Scene:
    """Return a scene of these lights."""
    return Scene(
        elements=lights, width=160, height=120, rate=RATE, exposure=0.5, texture=texture
    )


def watched(before: Scene, count: int, *, most: int = 1000) -> Watch:
    """Return what was seen of a scene in so many frames."""
    watch = Watch(exposure=0.5 / RATE, most=most)
    segmenter = Segmenter(flash=watch)
    for index in range(count):
        frame = Frame(before.frame(index), before.stamp_ns(index), 255)
        assert segmenter.update(frame) is None
    return watch


def test_lights_are_found_with_their_places_and_heights() -> None:
    """A wave and a code beside a lamp that is always on, before a wall with texture."""
    watch = watched(scene(
        Light(40.2, 30.7, 2.0, 120.0, periodic(10.0, 0.5)),
        Light(110.6, 80.1, 2.0, 80.0, coded('1101000', 1.0 / 59.7)),
        Light(80.0, 100.0, 2.0, 100.0, always), texture=4.0,
    ), 120)
    wave, code = sorted(watch.lights(), key=lambda light: light.rhythm.kind, reverse=True)
    assert wave.frequency == pytest.approx(10.0, abs=3.0 * wave.frequency_sigma)
    assert code.rhythm.bits == '1101000'
    for light, place, height in ((wave, (40.2, 30.7), 120.0), (code, (110.6, 80.1), 80.0)):
        # The median over some 60 frames, of a place good to 0.05 px each.
        assert np.median(light.path.x) == pytest.approx(place[0], abs=0.1)
        assert np.median(light.path.y) == pytest.approx(place[1], abs=0.1)
        amplitude, snr = watch.peak(light)
        assert amplitude == pytest.approx(height, rel=0.1) and snr > 50.0


def test_memory_is_bounded() -> None:
    """Of 40 frames 30 are kept; heights go with the points that are kept."""
    watch = watched(scene(Light(40.2, 30.7, 2.0, 120.0, periodic(15.0, 0.5))), 40, most=30)
    assert watch.found.seconds == pytest.approx(29.0 / RATE)
    light, = watch.lights()
    assert watch.peak(light)[0] == pytest.approx(120.0, rel=0.1)


def test_a_jump_of_the_stamps_begins_afresh() -> None:
    """What came before is of another time."""
    before = scene(Light(40.2, 30.7, 2.0, 120.0, periodic(15.0, 0.5)))
    watch = watched(before, 20)
    segmenter = Segmenter(flash=watch)
    with pytest.raises(FrameError, match='jumped back'):
        segmenter.update(Frame(before.frame(0), -10**9, 255))
    assert watch.found.seconds == 0.0
    assert watch.lights() == []
