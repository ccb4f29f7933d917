"""The flash in step with the camera, in simulated scenes: what must be found and what must not."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from blob_tracker.location import locate
from blob_tracker.segmentation import Segmenter
from blob_tracker.segmentation.alternate import Alternate
from blob_tracker.simulation import (
    AmbientLight, Drifting, Glints, HotPixels, in_step, Light, PassingObject, periodic, Scene,
    Sensor, sinusoid, Stepping, SunDisc,
)
from blob_tracker.types import Frame
import numpy as np
import pytest

RATE = 60.0
WALL = Scene(width=320, height=240, rate=RATE, exposure=0.3)
SLOW = Drifting(speed=3.0, radius=25.0, shake=1.0, turn=0.5)
# The target goes about in the upper left; what else there is stands elsewhere.
TARGET = Light(110.0, 75.0, 2.0, 60.0, in_step(RATE), reach_x=55.0, reach_y=30.0)
LAMPS = (
    Light(250.0, 40.0, 1.5, 60.0, sinusoid(100.0, 0.1)),
    Light(285.0, 70.0, 2.5, 80.0, sinusoid(100.0, 0.4, 0.2)),
    Light(250.0, 100.0, 1.2, 50.0, sinusoid(100.0, 1.0, 0.4)),
    Light(60.0, 190.0, 2.0, 70.0, sinusoid(120.0, 1.0, 0.3)),
    Light(110.0, 200.0, 1.5, 90.0, sinusoid(120.3, 1.0)),
)
CLUTTER: dict[str, tuple[Scene, tuple[Any, ...], str]] = {
    'lamps of 100 and 120 Hz': (WALL, LAMPS, 'none'),
    'moving edges': (WALL, (
        PassingObject(0.0, 190.0, 60.0, 36.0, 110.0, speed_x=4.0),
        PassingObject(268.0, 0.0, 30.0, 50.0, 8.0, speed_x=0.0, speed_y=-2.5),
    ), 'none'),
    'glints': (WALL, (Glints(rate=0.5, region=(0.0, 0.68, 1.0, 1.0), seed=4),), 'none'),
    'hot pixels': (
        WALL, (HotPixels(constant=25, blinking=15, region=(0.7, 0.0, 1.0, 0.64)),), 'none',
    ),
    'rolling shutter': (
        replace(WALL, sensor=Sensor(row_time=0.9 / (RATE * 240))),
        (AmbientLight(lambda t: sinusoid(100.0, 0.15)(t) / 1.15),),
        'none',
    ),
    'sun': (replace(WALL, camera=SLOW), (SunDisc(262.0, 65.0, radius=10.0),), 'affine'),
    'drifting camera': (replace(WALL, camera=SLOW), (), 'affine'),
}


def tracked(
    scene: Scene, frames: range, segmenter: Segmenter | None = None, reach: float = 1.5
) -> tuple[int, int, int]:
    """Return how many windows are on the target, how many are not, and how many flashes were."""
    segmenter = segmenter or Segmenter()
    right = wrong = flashes = 0
    for index in frames:
        window = segmenter.update(Frame(scene.frame(index), scene.stamp_ns(index), 255))
        x, y, lit, *_ = scene.truth(index)
        flashes += lit
        if window is None:
            continue
        height, width = window.lit.shape
        on = lit and np.hypot(
            window.x0 + (width - 1) / 2 - x, window.y0 + (height - 1) / 2 - y
        ) <= reach
        right, wrong = right + on, wrong + (not on)
    return right, wrong, flashes


@pytest.mark.parametrize('name', CLUTTER)
def test_the_target_is_found_in_clutter_and_nothing_else(name: str) -> None:
    """At a peak SNR near 40: every flash but the five at most by which it is confirmed."""
    scene, elements, registration = CLUTTER[name]
    segmenter = Segmenter(flash=Alternate(registration=registration))
    with_target = replace(scene, elements=elements, target=TARGET)
    right, wrong, flashes = tracked(with_target, range(1, 121), segmenter)
    assert wrong == 0
    assert right >= flashes - 5


@pytest.mark.parametrize('name', CLUTTER)
def test_clutter_without_a_target_gives_no_window(name: str) -> None:
    """Two seconds of it."""
    scene, elements, registration = CLUTTER[name]
    segmenter = Segmenter(flash=Alternate(registration=registration))
    _, wrong, _ = tracked(replace(scene, elements=elements), range(1, 121), segmenter)
    assert wrong == 0


def test_size_follows_the_blob_as_the_range_changes() -> None:
    """From 0.6 to 40 px within 80 flashes, as of a target that comes nearer: none is missed."""
    sigmas = np.geomspace(0.6, 40.0, 80)
    scene = Scene(width=640, height=480, rate=RATE, texture=3.0)
    segmenter = Segmenter()
    for step, sigma in enumerate(sigmas):
        light = Light(320.3, 240.4, float(sigma), 120.0, in_step(RATE))
        shown = replace(scene, target=light)
        window = None
        for index in (2 * step + 1, 2 * step + 2):
            window = segmenter.update(Frame(shown.frame(index), shown.stamp_ns(index), 255))
        assert window is not None, (sigma, segmenter.reason)
        half = max(3.0 * np.hypot(sigma, 0.29), 3.0)
        height, width = window.lit.shape
        # A tenth and a pixel; beyond 4 px binned pixels widen it, beyond 30 px its background is
        # taken where there still is some of it.
        for side in (height, width):
            assert (side - 1) / 2 == pytest.approx(half, rel=0.15, abs=1.0)
        assert abs(window.x0 + (width - 1) / 2 - 320.3) <= 0.6 + 0.1 * sigma
        assert abs(window.y0 + (height - 1) / 2 - 240.4) <= 0.6 + 0.1 * sigma


@pytest.mark.parametrize('registration, camera', [
    ('none', Stepping()),
    ('translation', Stepping()),
    ('affine', Stepping()),
    ('translation', Stepping(5.66, -5.66)),
    ('affine', Stepping(5.66, -5.66)),
    ('affine', Stepping(-8.0, 0.0, 1.0)),
    ('affine', Stepping(0.0, 8.0, -1.0)),
])
def test_registration_lays_the_frames_over_each_other(
    registration: str, camera: Stepping
) -> None:
    """8 px and 1 degree a frame, before a texture of a third of the light's height."""
    scene = replace(WALL, target=TARGET, camera=camera, texture=20.0)
    segmenter = Segmenter(flash=Alternate(registration=registration))
    right, wrong, flashes = tracked(scene, range(1, 41), segmenter)
    assert wrong == 0
    # The first is confirmed by the second flash, or at once.
    assert right >= flashes - 2


def test_without_registration_a_moving_camera_shows_no_target() -> None:
    """8 px a frame before a strong texture: the whole of it lights up somewhere."""
    scene = replace(WALL, target=TARGET, camera=Stepping(5.66, -5.66), texture=20.0)
    right, _, flashes = tracked(scene, range(1, 41))
    assert right <= 0.5 * flashes


def test_a_target_that_was_lost_is_found_again() -> None:
    """It is gone for two seconds, and comes back elsewhere: at once lost, soon locked."""
    target = replace(TARGET, reach_x=0.0, reach_y=0.0)
    here = replace(WALL, target=target)
    there = replace(here, target=replace(target, x=250.4, y=180.7))
    segmenter = Segmenter()
    assert tracked(here, range(1, 31), segmenter) == (15, 0, 15)
    assert segmenter.detections.state == 'locked'
    assert segmenter.detections.region.size < 0.1 * 320 * 240
    assert tracked(WALL, range(31, 151), segmenter)[:2] == (0, 0)
    assert segmenter.detections.state == 'lost'
    assert segmenter.detections.region.size == 320 * 240
    right, wrong, flashes = tracked(there, range(151, 181), segmenter)
    assert wrong == 0
    assert right >= flashes - 2
    assert segmenter.detections.state == 'locked'


def test_a_target_behind_something_is_found_again_near_by() -> None:
    """Two flashes hidden while it moves: the region grew, and the next one is taken."""
    scene = replace(WALL, target=TARGET)
    segmenter = Segmenter()
    tracked(scene, range(1, 31), segmenter)
    assert tracked(WALL, range(31, 35), segmenter)[:2] == (0, 0)
    assert segmenter.detections.state == 'locked'
    assert tracked(scene, range(35, 41), segmenter) == (3, 0, 3)


@pytest.mark.parametrize('light_rate, camera_rate', [(100.0, 60.0), (100.0, 30.0), (120.0, 50.0)])
def test_a_lamp_alone_is_never_the_target(light_rate: float, camera_rate: float) -> None:
    """It goes dark and comes back in a pattern of three frames, or of five."""
    lamp = Light(150.2, 120.6, 2.0, 80.0, sinusoid(light_rate, 1.0, 0.1))
    scene = replace(WALL, elements=(Light(220.0, 60.0, 1.5, 70.0), lamp), rate=camera_rate)
    segmenter = Segmenter()
    empty = replace(scene, elements=())
    # Nothing is the first light: the scene is known when the lamp is switched on.
    tracked(empty, range(1, 9), segmenter)
    assert tracked(scene, range(9, 129), segmenter)[:2] == (0, 0)


@pytest.mark.parametrize('frequency', [7.3, 10.0, 14.9])
def test_a_light_of_another_rhythm_is_never_the_target(frequency: float) -> None:
    """It rises in each fourth or sixth frame, or so: in step but for what it leaves out."""
    scene = replace(WALL, elements=(Light(110.0, 75.0, 2.0, 60.0, periodic(frequency, 0.5)),))
    right, wrong, _ = tracked(scene, range(120))
    # In the first pairs a light alone is trusted.
    assert right + wrong <= 1


def test_a_mask_hides_the_target() -> None:
    """And one of another size is named."""
    scene = replace(WALL, target=replace(TARGET, reach_x=0.0, reach_y=0.0))
    mask = np.ones((240, 320), np.uint8)
    mask[50:100, 80:140] = 0
    assert tracked(scene, range(1, 21), Segmenter(mask=mask))[:2] == (0, 0)
    assert tracked(scene, range(1, 21), Segmenter(mask=1 - mask))[0] == 10
    with pytest.raises(ValueError, match='the mask is 10 x 20 px and the frame 320 x 240'):
        tracked(scene, range(1, 2), Segmenter(mask=np.ones((20, 10))))


def test_looks_at_a_still_target_are_summed() -> None:
    """Five of them place it twice as well as one, 2.24 times but for the pixels' rounding."""
    still = replace(WALL, target=replace(TARGET, amplitude=25.0, reach_x=0.0, reach_y=0.0))
    errors = {}
    for looks in (1, 5):
        segmenter = Segmenter(looks=looks)
        found = []
        for index in range(1, 401):
            frame = Frame(still.frame(index), still.stamp_ns(index), 255)
            window = segmenter.update(frame)
            if window is not None:
                assert window.looks == looks
                found.append(locate(window, noise=still.sensor.noise).x - 110.0)
        assert len(found) == pytest.approx(200 / looks, abs=2)
        errors[looks] = np.std(found)
    # 40 places know their deviation to 11 %.
    assert errors[1] / errors[5] == pytest.approx(np.sqrt(5), rel=0.25)


def test_a_faint_target_is_held_where_it_is_expected() -> None:
    """At 2.3 standard deviations of a pixel, which the whole frame hardly shows."""
    still = replace(TARGET, amplitude=4.0, reach_x=0.0, reach_y=0.0)
    faint = replace(WALL, target=still, texture=0.0)
    bright = replace(faint, target=replace(still, amplitude=8.0))
    followed = Segmenter()
    tracked(bright, range(1, 21), followed)
    # 3 px is one and a half of its sigma: so faint a blob is measured to half a sigma.
    held, beside, flashes = tracked(faint, range(21, 101), followed, reach=3.0)
    found, wrong, _ = tracked(faint, range(21, 101), reach=3.0)
    assert beside == wrong == 0
    assert held >= 0.9 * flashes
    assert held > 1.5 * found


@pytest.mark.parametrize('x, y, published', [
    (2.0, 120.0, False), (6.0, 120.0, True), (317.5, 120.0, False), (160.0, 1.5, False),
    (160.0, 238.0, False), (160.0, 235.0, True),
])
def test_a_target_that_the_frame_cuts_is_published_by_a_rule(
    x: float, y: float, published: bool
) -> None:
    """Where a side has half of the other or less, of a box of six px, it is not."""
    scene = replace(WALL, target=Light(x, y, 2.0, 100.0, in_step(RATE)))
    segmenter = Segmenter()
    right, wrong, flashes = tracked(scene, range(1, 9), segmenter, reach=4.0)
    assert wrong == 0
    assert right == (flashes if published else 0)
    if not published:
        segmenter.update(Frame(scene.frame(10), scene.stamp_ns(10), 255))
        assert segmenter.reason


def test_a_saturated_target_is_published() -> None:
    """Clipped pixels are the locator's to leave out; the window says where they clip."""
    scene = replace(WALL, target=replace(TARGET, amplitude=700.0))
    right, wrong, flashes = tracked(scene, range(1, 21))
    assert (right, wrong) == (flashes, 0)
