"""What flashes in step is confirmed and followed; what does not is never taken for it."""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.segmentation.box import Box, whole
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.confirmation import Confirmation
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.flash_tracks import MAX_AGE_FRAMES
import numpy as np
import pytest
from support.contrasts import candidate_at

SHAPE = (480, 640)
STEP_NS = 16_666_667
GATE = 24.0
NOISE_PEAK = candidate_at(20, 20, height=9.0)


class Camera:
    """Frames in which this or that lights up."""

    def __init__(self, shape: tuple[int, int] = SHAPE) -> None:
        self.shape = shape
        self.confirmation = Confirmation(GATE)

    def see(self, index: float, *candidates: Candidate) -> Candidate | None:
        """Take the frame of this index; return what is chosen in it."""
        self.confirmation.push(10**9 + round(index * STEP_NS))
        return self.confirmation.choose(candidates, self.shape)

    def warm_up(self) -> int:
        """Take frames of an empty scene, so that no light is the first one; return the next."""
        for index in range(4):
            assert self.see(index) is None
        return 4


def light(index: float, speed: float = 0.0) -> Candidate:
    """Return a light at a constant speed, px a frame."""
    x = 200.0 + speed * index
    return candidate_at(round(x), 100, x=x)


def test_a_single_light_is_trusted_at_once() -> None:
    """In the first three pairs, where nothing speaks against it."""
    camera = Camera()
    assert camera.see(1) is None
    assert camera.see(2, light(2)) is not None
    assert camera.confirmation.locked


def test_a_light_among_others_must_flash_again() -> None:
    """Two that light up in the first frame: neither is known."""
    camera = Camera()
    assert camera.see(1, light(1), candidate_at(500, 300)) is None
    assert not camera.confirmation.locked


@pytest.mark.parametrize('first, empty, needed', [(0, 4, 3), (1, 4, 3), (0, 600, 2), (1, 600, 2)])
def test_locks_in_either_phase(first: int, empty: int, needed: int) -> None:
    """At the third flash, at the second where nothing lit up for ten seconds, and on."""
    camera = Camera()
    for index in range(empty + first):
        assert camera.see(index) is None
    start = empty + first
    found = [
        index for index in range(start, start + 20)
        if camera.see(index, *([light(index)] if (index - start) % 2 == 0 else [])) is not None
    ]
    assert found == list(range(start + 2 * (needed - 1), start + 20, 2))


def confirmed(lights: Callable[[int], bool], frames: int = 120) -> int:
    """Return how often a light that is on where this says is chosen."""
    camera = Camera()
    start = camera.warm_up()
    found = 0
    for index in range(start, start + frames):
        found += camera.see(index, *([light(index)] if lights(index) else [])) is not None
    return found


@pytest.mark.parametrize('lights, name', [
    (lambda index: True, 'every frame'),
    (lambda index: index % 3 == 0, 'every third'),
    (lambda index: index % 3 != 0, 'two of three: 100 Hz at 60 frames a second'),
    (lambda index: index % 5 in (0, 2), 'two of five: 120 Hz at 50 frames a second'),
], ids=['every frame', 'every third', 'two of three', 'two of five'])
def test_what_lights_up_out_of_step_is_never_confirmed(lights, name: str) -> None:
    """Though two flashes of some of these are two frames apart."""
    assert confirmed(lights) == 0, name


def test_what_is_refused_in_the_other_phase_speaks_against_a_light() -> None:
    """A lamp of which one phase passes for a blob, and the other for a lamp."""
    camera = Camera()
    start = camera.warm_up()
    for index in range(start, start + 6):
        seen = light(index)
        if index % 2:
            seen = seen._replace(rejected='a lamp that flickers')
        assert camera.see(index, seen) is None


@pytest.mark.parametrize('lost', [[10], [11], [10, 11], [10, 11, 12], [9, 12]])
def test_dropped_frames_cost_themselves(lost: list[int]) -> None:
    """The stamps tell how many there were."""
    camera = Camera()
    found = [
        index for index in range(1, 30)
        if index not in lost
        and camera.see(index, *([light(index, 2.0)] if index % 2 == 0 else [])) is not None
    ]
    assert found == [index for index in range(2, 30, 2) if index not in lost]


def test_stamps_that_tremble_are_still_in_step() -> None:
    """By a fifth of the time between frames, either way."""
    random = np.random.default_rng(2)
    camera = Camera()
    found = sum(
        camera.see(
            index + random.uniform(-0.1, 0.1), *([light(index)] if index % 2 == 0 else [])
        ) is not None
        for index in range(1, 61)
    )
    assert found == 30


def test_a_slip_is_followed_by_a_new_lock() -> None:
    """The light is on in the frame 11 as well and from there in the odd ones; 13 rises again."""
    camera = Camera()
    for index in range(1, 11):
        camera.see(index, *([light(index)] if index % 2 == 0 else []))
    found = [
        index for index in range(11, 31)
        if camera.see(
            index, *([light(index)] if index % 2 == 1 and index > 11 else [])
        ) is not None
    ]
    assert found == list(range(13, 31, 2))


@pytest.mark.parametrize('speed', [0.0, 3.0, 10.0])
def test_the_region_follows_a_constant_speed(speed: float) -> None:
    """The light stays in the middle of it, and it is far smaller than the frame."""
    camera = Camera()
    for index in range(1, 41):
        camera.confirmation.push(10**9 + index * STEP_NS)
        region = camera.confirmation.region(SHAPE)
        seen = light(index, speed)
        if index > 4:
            assert region.size < 0.03 * SHAPE[0] * SHAPE[1]
            assert (region.x0 + region.x1 - 1) / 2 == pytest.approx(seen.x, abs=1.0)
        camera.confirmation.choose([seen] if index % 2 == 0 else [], SHAPE)


def test_the_region_grows_when_flashes_are_missed_and_ends_in_the_whole() -> None:
    """It doubles with each of them; the track ends after eight frames."""
    camera = Camera()
    for index in range(1, 11):
        camera.see(index, *([light(index)] if index % 2 == 0 else []))
    sides = []
    for index in range(11, 21):
        camera.confirmation.push(10**9 + index * STEP_NS)
        region = camera.confirmation.region(SHAPE)
        sides.append(region.x1 - region.x0)
        assert camera.confirmation.locked is (index - 10 <= MAX_AGE_FRAMES)
        camera.confirmation.choose([], SHAPE)
    assert sides == sorted(sides)
    # Frame 12 is the first in which it is expected, 14 the first after it was missed.
    assert sides[0] == sides[1] and sides[2] == pytest.approx(2 * sides[1], abs=2)
    assert region == whole(SHAPE)


def test_the_region_is_within_the_frame() -> None:
    """A light that leaves it has its region at the border."""
    camera = Camera()
    for index in range(1, 41):
        camera.confirmation.push(10**9 + index * STEP_NS)
        region = camera.confirmation.region(SHAPE)
        assert region.size > 0
        assert region == Box(
            max(region.x0, 0), max(region.y0, 0), min(region.x1, 640), min(region.y1, 480)
        )
        seen = light(index, 15.0)
        camera.confirmation.choose(
            [seen] if index % 2 == 0 and seen.x < 639 else [], SHAPE
        )


def test_a_light_that_jumps_beyond_the_gate_is_another() -> None:
    """What is too far from it begins anew."""
    camera = Camera()
    for index in range(600):
        camera.see(index)
    chosen = [
        camera.see(index, *([candidate_at(200 + jump, 100)] if index % 2 == 0 else []))
        for index, jump in enumerate((0, 0, 60, 0, 60, 0, 60), 600)
    ]
    # New things that light up are counted on: the third flash of the other one confirms it.
    assert [each is not None for each in chosen] == 6 * [False] + [True]


def on_a_bend(flash: int, radius: float = 15.0, turn: float = 1.5) -> Candidate:
    """Return a light that turns by 86 degrees from flash to flash, 20 px apart."""
    x, y = 200.0 + radius * np.cos(turn * flash), 100.0 + radius * np.sin(turn * flash)
    return candidate_at(round(x), round(y), x=x, y=y)


def test_a_light_that_turns_is_followed() -> None:
    """It is nowhere near where its speed would have it, and within the gate of its last place."""
    camera = Camera()
    for index in range(2, 60):
        camera.confirmation.push(10**9 + index * STEP_NS)
        seen = [on_a_bend(index // 2)] if index % 2 == 0 else []
        box = camera.confirmation.region(SHAPE)
        inside = [each for each in seen if box.x0 <= each.x < box.x1 and box.y0 <= each.y < box.y1]
        if camera.confirmation.widened(inside, SHAPE):
            box = camera.confirmation.region(SHAPE)
            assert box.size < 0.05 * SHAPE[0] * SHAPE[1] and not index % 2
            assert not camera.confirmation.widened(seen, SHAPE)  # it is looked for there once
        assert (camera.confirmation.choose(seen, SHAPE) is not None) == bool(seen)


def test_where_things_light_up_by_chance_no_light_is_taken_for_one_that_turns() -> None:
    """One in ten frames, in either phase: it is followed by its speed alone."""
    camera = Camera((240, 320))
    for index in range(4, 104):
        camera.see(index, *([candidate_at(20 + index, 200)] if index % 10 in (0, 5) else []))
    for index in range(104, 124):
        camera.see(index, *([candidate_at(200, 100)] if index % 2 == 0 else []))
    assert camera.confirmation.locked
    camera.confirmation.push(10**9 + 124 * STEP_NS)
    assert not camera.confirmation.widened([], camera.shape)


def test_a_light_that_turns_is_found_again() -> None:
    """After pictures in either phase, in which its own flashes were taken for chance."""
    camera = Camera()
    start = camera.warm_up()
    for index in range(start, start + 60):
        camera.see(index, *([on_a_bend(index)] if index % 3 else []))
    found = [
        camera.see(index, *([on_a_bend(index // 2)] if index % 2 == 0 else [])) is not None
        for index in range(64, 84)
    ]
    assert any(found[:18:2]) and not any(found[1::2])


def test_what_is_beyond_the_gate_is_said() -> None:
    """By how far it is, and what to set."""
    camera = Camera()
    start = camera.warm_up()
    for index in range(start, start + 5):
        jumped = candidate_at(200 + 20 * index, 100)
        camera.see(index, *([jumped] if index % 2 == 0 else []))
    reason = camera.confirmation.why_another(jumped)
    assert '40 px' in reason and '24 px' in reason and 'gate' in reason
    assert camera.confirmation.why_another(candidate_at(330, 100)) == ''


def test_a_light_of_another_brightness_is_another() -> None:
    """Three times as bright as two frames ago."""
    camera = Camera()
    for index in range(600):
        camera.see(index)
    chosen = [
        camera.see(index, *([light(0)._replace(height=height)] if index % 2 == 0 else []))
        for index, height in enumerate((100.0, 0.0, 300.0, 0.0, 300.0, 0.0, 300.0), 600)
    ]
    assert [each is not None for each in chosen] == 6 * [False] + [True]


def flashes_needed(rate: float, seed: int) -> int:
    """Return how many flashes it takes in a scene where so many things light up a frame."""
    random = np.random.default_rng(seed)
    camera = Camera()

    def clutter() -> list[Candidate]:
        return [
            candidate_at(int(random.integers(640)), int(random.integers(300, 480)))
            for _ in range(random.poisson(rate))
        ]

    for index in range(1, 100):
        camera.see(index, *clutter())
    for flash in range(1, 20):
        chosen = camera.see(98 + 2 * flash, light(0), *clutter())
        camera.see(99 + 2 * flash, *clutter())
        if chosen is not None and chosen.row == 100:
            return flash
    return 20


def test_a_busy_scene_asks_for_more_flashes() -> None:
    """Chance must not confirm what it makes."""
    needed = [max(flashes_needed(rate, seed) for seed in range(3)) for rate in (0.0, 0.5, 6.0)]
    assert needed == sorted(needed)
    assert needed[0] <= 3 < needed[2]


def test_chance_confirms_nothing_in_a_busy_scene() -> None:
    """Glints anywhere, two a frame, in 3000 frames: one chosen at most."""
    random = np.random.default_rng(8)
    camera = Camera()
    chosen = 0
    for index in range(3000):
        # None is alone in the first frames, where it would be trusted.
        count = random.poisson(2.0) if index > 3 else 2
        places = random.integers(0, (640, 480), (count, 2))
        chosen += camera.see(index, *(candidate_at(int(x), int(y)) for x, y in places)) is not None
    assert chosen <= 1


def test_of_two_flashes_the_greater_snr_is_taken() -> None:
    """And kept, whatever comes after it."""
    camera = Camera()
    start = camera.warm_up()
    other = candidate_at(500, 300, snr=150.0)
    for index in range(start, start + 11):
        chosen = camera.see(index, *([light(0), other] if (index - start) % 2 == 0 else []))
    assert chosen is not None and chosen.peak == (500, 300)
    camera.see(start + 11)
    chosen = camera.see(start + 12, light(0)._replace(snr=400.0), other)
    assert chosen is not None and chosen.peak == (500, 300)


@pytest.mark.parametrize('count', [31, 40, 100, 300, 900])
def test_the_brightest_of_a_crowd_in_step_is_found(count: int) -> None:
    """Dots of a projector: more than are kept, seen in any order."""
    random = np.random.default_rng(count)
    places = random.permutation([(x, y) for x in range(8, 640, 16) for y in range(150, 480, 12)])
    heights = random.uniform(50.0, 100.0, count)
    dots = [
        candidate_at(int(x), int(y), height=height, snr=height)
        for (x, y), height in zip(places, heights)
    ]
    target = light(0)._replace(height=150.0, snr=150.0)
    camera = Camera()
    found = []
    for index in range(40):
        shown = random.permutation(np.array([*dots, target], dtype=object)).tolist()
        chosen = camera.see(index, *(Candidate(*each) for each in shown if index % 2 == 0))
        if chosen is not None:
            assert chosen.peak == target.peak
            found.append(index)
    # Seven flashes confirm it at most: at the first one all of the crowd is new.
    assert found == list(range(found[0], 40, 2)) and found[0] <= 12


@pytest.mark.parametrize('count', [20, 40])
def test_a_light_among_glints_in_every_frame_is_found(count: int) -> None:
    """As bright as they are, and none of them is taken for it."""
    random = np.random.default_rng(count)
    camera = Camera()
    found = []
    for index in range(200):
        places = random.integers((0, 130), (640, 480), (count, 2))
        glints = [
            candidate_at(int(x), int(y), height=height, sigma_x=1.2, sigma_y=1.2)
            for (x, y), height in zip(places, random.uniform(50.0, 150.0, count))
        ]
        chosen = camera.see(index, *glints, *([light(0)] if index % 2 == 0 else []))
        if chosen is not None:
            assert chosen.peak == (200, 100)
            found.append(index)
    assert found == list(range(found[0], 200, 2)) and found[0] <= 40


def test_chance_confirms_nothing_among_glints_in_every_frame() -> None:
    """20 of them a frame, anywhere in a small one; in 1500 frames one chosen at most."""
    random = np.random.default_rng(11)
    camera = Camera((240, 320))
    chosen = 0
    for index in range(1500):
        places = random.integers(0, (320, 240), (20, 2))
        chosen += camera.see(
            index, *(candidate_at(int(x), int(y), sigma_x=1.2, sigma_y=1.2) for x, y in places)
        ) is not None
    assert chosen <= 1


def two_lights(index: int, *, hidden: bool, ratio: float = 0.5, distance: float = 40.0):
    """Return the lights of a frame: the target unless it is hidden, and its reflection."""
    if index % 2:
        return []
    target = light(0)
    other = candidate_at(
        round(200 + distance), 100,
        height=100.0 * ratio, snr=100.0 * ratio, amplitude=100.0 * ratio,
    )
    return [other] if hidden else [target, other]


class Surveyor(Camera):
    """Frames of which the region is searched first, and the rest where it is asked for."""

    def look(self, index: int, *candidates: Candidate) -> Candidate | None:
        """Take the frame of this index; return what is chosen in it."""
        self.confirmation.push(10**9 + round(index * STEP_NS))
        region = self.confirmation.region(self.shape)
        inside = [
            each for each in candidates
            if region.x0 <= each.x < region.x1 and region.y0 <= each.y < region.y1
        ]
        chosen = self.confirmation.choose(inside, self.shape)
        if self.confirmation.surveys:
            self.confirmation.survey(candidates, region)
        return chosen


@pytest.mark.parametrize('hidden', [1, 2, 5, 10, 15])
@pytest.mark.parametrize('ratio, distance', [
    (0.5, 40.0), (0.5, 20.0), (0.5, 150.0), (0.75, 60.0), (1.0, 60.0)
])
def test_a_target_that_was_hidden_is_returned_to(
    hidden: int, ratio: float, distance: float
) -> None:
    """And until then nothing is taken for it."""
    camera = Surveyor()
    turn = 60 + 2 * hidden
    for index in range(4 * turn):
        away = index % turn >= 60
        lights = two_lights(index, hidden=away, ratio=ratio, distance=distance)
        chosen = camera.look(index, *lights)
        if chosen is not None:
            assert chosen.peak == (200, 100)
        if away and index % 2 == 0 and index % turn >= 70:
            assert 'another light flashes in step' in camera.confirmation.reason
        if index > turn and 12 <= index % turn < 60 and index % 2 == 0:
            assert chosen is not None
    assert '2 lights flash in step' in camera.confirmation.warning


def test_a_reflection_that_is_seen_first_is_left_for_the_brighter_light() -> None:
    """It is a light by itself for the first half second."""
    camera = Surveyor()
    for index in range(100):
        chosen = camera.look(index, *two_lights(index, hidden=index < 30))
        if index % 2 == 0 and index >= 40:
            assert chosen is not None and chosen.peak == (200, 100)


def test_a_reflection_that_was_alone_for_long_is_left_for_a_light_that_stays_brighter() -> None:
    """It is named as soon as both are searched for, and left after two seconds more."""
    camera = Surveyor()
    chosen_at = {}
    for index in range(600):
        chosen = camera.look(index, *two_lights(index, hidden=index < 200))
        if chosen is not None:
            chosen_at[index] = chosen.peak[0]
        if index == 270:
            assert '2 lights flash in step' in camera.confirmation.warning
    assert {chosen_at.get(index) for index in range(10, 380, 2)} == {240}
    assert {chosen_at.get(index) for index in range(520, 600, 2)} == {200}


def test_what_outshines_a_light_for_a_moment_is_not_taken() -> None:
    """It flashes in step for a second, while both are searched for, and is gone."""
    camera = Surveyor()
    for index in range(600):
        seen = two_lights(index, hidden=not 240 <= index < 300)
        chosen = camera.look(index, *seen)
        assert chosen is None or chosen.peak[0] == 240


def test_a_light_that_stays_the_only_one_is_taken_after_a_second() -> None:
    """And left for the target once that is back, ten seconds later."""
    camera = Surveyor()
    chosen_at = {}
    for index in range(1000):
        chosen = camera.look(index, *two_lights(index, hidden=100 <= index < 700))
        if chosen is not None:
            chosen_at[index] = chosen.peak[0]
    assert {peak for index, peak in chosen_at.items() if index < 100} == {200}
    assert not {index for index in chosen_at if 100 <= index < 158}
    assert {peak for index, peak in chosen_at.items() if 100 <= index < 700} == {240}
    assert min(index for index, peak in chosen_at.items() if peak == 240) <= 170
    assert {chosen_at.get(index) for index in range(710, 1000, 2)} == {200}


def test_a_light_that_jumps_alone_is_not_waited_for() -> None:
    """Nothing flashed beside it: what flashes elsewhere in step from then on is the light."""
    camera = Surveyor()
    found = []
    for index in range(100):
        x = 200 if index < 60 else 330
        if camera.look(index, *([candidate_at(x, 100)] if index % 2 == 0 else [])) is not None:
            found.append(index)
    # Frame 66 is the first that is searched whole, and the third flash from there on confirms it.
    assert [index for index in found if index >= 60][0] <= 70


def test_what_passes_by_is_no_light_in_step() -> None:
    """Stay with a light while something brighter moves by, and so lights up in each frame."""
    camera = Surveyor()
    for index in range(120):
        passing = candidate_at(20 + 11 * index % 600, 150, height=150.0)
        target = [candidate_at(200, 300, height=60.0)] if index % 2 == 0 else []
        chosen = camera.look(index, passing, *target)
        if index >= 20:
            assert (chosen.peak if chosen else None) == ((200, 300) if target else None)
            assert camera.confirmation.warning == ''


@pytest.mark.parametrize('distance', [9.0, 12.0, 30.0])
def test_a_trembling_target_is_waited_for_as_well(distance: float) -> None:
    """By a pixel in 20 flashes, so that its speed says nothing of where its reflection is."""
    random = np.random.default_rng(77)
    camera = Surveyor()
    found = 0
    for index in range(320):
        x, y = 200.0 + random.uniform(-1.0, 1.0), 100.0 + random.uniform(-1.0, 1.0)
        hidden = index % 80 >= 40
        lights = [] if hidden else [candidate_at(round(x), round(y), x=x, y=y)]
        lights.append(candidate_at(
            round(x + distance), round(y), x=x + distance, y=y, height=45.0, snr=45.0,
        ))
        chosen = camera.look(index, *(lights if index % 2 == 0 else []))
        if chosen is not None:
            assert chosen.height == 100.0
            found += 1
    assert found > 60


def test_no_dot_of_a_dense_grid_is_taken_where_the_target_is_missed() -> None:
    """Every fifth flash, among dots 14 px apart that are not all seen each time."""
    random = np.random.default_rng(78)
    places = [(x, y) for x in range(100, 301, 14) for y in range(30, 171, 14)]
    dots = [
        candidate_at(x, y, height=height, snr=height)
        for (x, y), height in zip(places, random.uniform(30.0, 90.0, len(places)))
        if abs(x - 200) > 7 or abs(y - 100) > 7
    ]
    target = candidate_at(200, 100, height=140.0, snr=140.0)
    camera = Surveyor()
    found = 0
    for index in range(300):
        shown = [each for each in dots if random.uniform() < 0.9]
        if index < 60 or index // 2 % 5:
            shown.append(target)
        chosen = camera.look(index, *(shown if index % 2 == 0 else []))
        if index >= 60 and chosen is not None:
            assert chosen.peak == target.peak
            found += 1
    assert found > 85


def test_another_view_tells_which_of_two_lights_it_is() -> None:
    """The fainter one; also where the other one was followed already."""
    strong, faint = candidate_at(200, 100), candidate_at(260, 100, height=60.0)
    there = Expectation(262.0, 101.0, 36.0 * np.eye(2))
    for told_from in (0, 20):
        camera = Camera()
        found = []
        for index in range(40):
            camera.confirmation.push(
                10**9 + index * STEP_NS, None, SHAPE, there if index >= told_from else None)
            found.append(camera.confirmation.choose(
                (strong, faint) if index % 2 == 0 else (), SHAPE))
        assert strong not in found[told_from:]
        assert found[30::2] == [faint] * 5
