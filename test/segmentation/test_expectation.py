"""A tracker tells where the light will be: it helps where it is right, and never hurts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from blob_tracker.segmentation import Expectation, flash_by_name, FLASH_MODES, Segmenter
from blob_tracker.segmentation.alternate import Alternate
from blob_tracker.segmentation.box import whole
from blob_tracker.simulation import Drifting, in_step, Light, Scene
from blob_tracker.types import Frame
import numpy as np
from numpy.typing import NDArray
import pytest

RATE = 60.0
WALL = Scene(width=320, height=240, rate=RATE, exposure=0.3)
STILL = Light(110.0, 75.0, 2.0, 60.0, in_step(RATE))
FRAMES = range(1, 121)
TIGHT = 4.0 * np.eye(2)  # px^2

Expected = Callable[[int], Expectation | None]
Place = Callable[[int], tuple[float, float]]


def erratic() -> Place:
    """Return places of a light that is thrown about by up to 40 px a flash, after a calm start."""
    random = np.random.default_rng(9)
    jumps = np.cumsum(random.uniform(-28.0, 28.0, (len(FRAMES) // 2 + 2, 2)), axis=0)
    jumps[:4] = 0.0
    # Folded back at the borders of the middle of the frame.
    places = np.array([60.0, 50.0]) + np.abs((jumps + (100.0, 70.0)) % (400.0, 280.0)
                                             - (200.0, 140.0))
    return lambda index: (float(places[index // 2, 0]), float(places[index // 2, 1]))


def frames(scene: Scene, place: Place) -> list[tuple[Frame, bool]]:
    """Return frames of a light that is at these places, and whether it is on."""
    out = []
    for index in FRAMES:
        x, y = place(index)
        shown = replace(scene, target=replace(STILL, x=x, y=y))
        frame = Frame(shown.frame(index), shown.stamp_ns(index), 255)
        out.append((frame, shown.truth(index).lit))
    return out


def middles(
    seen: list[tuple[Frame, bool]], expected: Expected, segmenter: Segmenter | None = None
) -> dict[int, NDArray[np.float64]]:
    """Return the middle of the window in each frame that has one."""
    segmenter = segmenter or Segmenter()
    found = {}
    for index, (frame, _) in zip(FRAMES, seen):
        window = segmenter.update(frame, expected(index))
        if window is not None:
            height, width = window.lit.shape
            found[index] = np.array([
                window.x0 + 0.5 * (width - 1) * window.binning[0],
                window.y0 + 0.5 * (height - 1) * window.binning[1],
            ])
    return found


def on_target(found: dict[int, NDArray[np.float64]], place: Place) -> int:
    """Return how many windows are on the light; none may be elsewhere."""
    for index, middle in found.items():
        assert np.abs(middle - place(index)).max() <= 1.5
    return len(found)


@pytest.fixture(scope='module')
def thrown() -> tuple[Place, list[tuple[Frame, bool]]]:
    """Give a light that is thrown about."""
    place = erratic()
    return place, frames(WALL, place)


def test_what_is_thrown_beyond_the_gate_is_followed(
    thrown: tuple[Place, list[tuple[Frame, bool]]]
) -> None:
    """Every flash is found with the expectation, good to 2 px; a third of them is lost without."""
    place, seen = thrown
    random = np.random.default_rng(3)

    def expected(index: int) -> Expectation:
        x, y = place(index) + random.normal(0.0, 2.0, 2)
        return Expectation(x, y, TIGHT)

    flashes = sum(lit for _, lit in seen)
    segmenter = Segmenter()
    assert on_target(middles(seen, expected, segmenter), place) == flashes
    assert segmenter.detections is not None and segmenter.detections.region.size < 0.1 * 320 * 240
    assert on_target(middles(seen, lambda index: None), place) < 0.7 * flashes


@pytest.mark.parametrize('crop, binning', [((40, 30), (1, 1)), ((100, 60), (2, 2))])
def test_it_is_in_pixels_of_the_full_sensor(
    thrown: tuple[Place, list[tuple[Frame, bool]]], crop: tuple[int, int], binning: tuple[int, int]
) -> None:
    """Of a frame that is cropped or binned in hardware."""
    place, seen = thrown
    across, down = binning

    def on_sensor(index: int) -> tuple[float, float]:
        x, y = place(index)
        return (x + 0.5) * across - 0.5 + crop[0], (y + 0.5) * down - 0.5 + crop[1]

    elsewhere = [
        (replace(frame, x0=crop[0], y0=crop[1], binning=binning), lit) for frame, lit in seen
    ]
    found = middles(
        elsewhere,
        lambda index: Expectation(*on_sensor(index), TIGHT * np.outer(binning, binning)),
    )
    assert len(found) == sum(lit for _, lit in seen)


def never(index: int) -> tuple[float, float]:
    """Return the place of a light that stands still."""
    return STILL.x, STILL.y


USELESS: dict[str, Expected] = {
    'NaN': lambda index: Expectation(np.nan, 75.0, TIGHT),
    'infinite': lambda index: Expectation(110.0, np.inf, TIGHT),
    'outside': lambda index: Expectation(-50.0, 75.0, TIGHT),
    'far outside': lambda index: Expectation(1e300, -1e300, TIGHT),
    'covariance NaN': lambda index: Expectation(110.0, 75.0, np.full((2, 2), np.nan)),
    'covariance infinite': lambda index: Expectation(110.0, 75.0, np.diag([1.0, np.inf])),
    'covariance negative': lambda index: Expectation(110.0, 75.0, -TIGHT),
    'covariance indefinite': lambda index: Expectation(
        110.0, 75.0, np.array([[1.0, 2.0], [2.0, 1.0]])
    ),
    'covariance huge': lambda index: Expectation(110.0, 75.0, 1e6 * np.eye(2)),
    'covariance absurd': lambda index: Expectation(110.0, 75.0, 1e300 * np.eye(2)),
    'far from the truth': lambda index: Expectation(250.0, 190.0, TIGHT),
    'certain, and wrong': lambda index: Expectation(150.0, 75.0, np.zeros((2, 2))),
    'anywhere': lambda index: Expectation(37.0 * index % 320, 53.0 * index % 240, TIGHT),
}


@pytest.mark.parametrize('registration', ['none', 'affine'])
@pytest.mark.parametrize('wrong', USELESS)
def test_a_wrong_one_costs_nothing(wrong: str, registration: str) -> None:
    """A moving light is found in the very frames, by the very windows, as without it."""
    def place(index: int) -> tuple[float, float]:
        return 110.0 + 40.0 * np.sin(0.07 * index), 75.0 + 30.0 * np.cos(0.05 * index)

    scene = WALL if registration == 'none' else replace(WALL, camera=Drifting(speed=1.0))
    seen = frames(scene, place)[:60]
    one, other = (
        middles(seen, expected, Segmenter(flash=Alternate(registration=registration)))
        for expected in (USELESS[wrong], lambda index: None)
    )
    assert list(one) == list(other)
    assert len(one) == sum(lit for _, lit in seen)
    np.testing.assert_array_equal(list(one.values()), list(other.values()))


def test_a_leap_that_was_not_expected_is_found_as_without_it() -> None:
    """A tracker that believes the light to be where it was for a second."""
    def place(index: int) -> tuple[float, float]:
        return never(index) if index < 40 else (250.0, 180.0)

    seen = frames(WALL, place)
    stale = middles(seen, lambda index: Expectation(*never(index), TIGHT))
    without = middles(seen, lambda index: None)
    assert list(stale) == list(without)
    assert max(stale) >= 118 and on_target(stale, place) > 40


def test_what_flashes_outside_of_the_region_is_not_taken() -> None:
    """Bright, in step, where the light would have been had it gone on: it turned, as expected."""
    def place(index: int) -> tuple[float, float]:
        steps = index // 2
        return (60.0 + 3.0 * min(steps, 30), 75.0 + 6.0 * max(steps - 30, 0))

    def shown(index: int) -> Frame:
        x, y = place(index)
        scene = replace(WALL, target=replace(STILL, x=x, y=y))
        if index >= 62:
            other = replace(STILL, x=60.0 + 3.0 * (index // 2), y=75.0, amplitude=120.0)
            scene = replace(scene, elements=(other,))
        return Frame(scene.frame(index), scene.stamp_ns(index), 255)

    seen = [(shown(index), index % 2 == 0) for index in FRAMES if place(index)[1] < 220.0]

    def wrong(expected: Expected) -> int:
        """Return how many of the windows are on the other one."""
        return sum(
            bool(np.abs(middle - place(index)).max() > 3.0)
            for index, middle in middles(seen, expected).items()
        )

    # At the turn both are within a window of each other, for two flashes.
    assert wrong(lambda index: Expectation(*place(index), 0.25 * np.eye(2))) <= 2
    assert wrong(lambda index: None) > 10


@pytest.mark.parametrize('x, y, inside', [
    (0.0, 0.0, True), (-0.5, -0.5, True), (-0.6, 0.0, False), (319.4, 239.4, True),
    (319.5, 0.0, False), (0.0, np.nan, False),
])
def test_inside_the_frame(x: float, y: float, inside: bool) -> None:
    """To the outer edges of its pixels."""
    assert Expectation(x, y, TIGHT).inside((240, 320)) is inside


def test_reach_is_four_sigma_of_the_longest_axis() -> None:
    """Of an ellipse that lies askew; of an area of none as well."""
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    askew = turn @ np.diag([9.0, 1.0]) @ turn.T
    assert Expectation(0.0, 0.0, askew).gate_radius_px == pytest.approx(12.0)
    assert Expectation(0.0, 0.0, np.zeros((2, 2))).gate_radius_px == 0.0


def test_other_modes_search_the_whole_frame() -> None:
    """They say so, and do not mind."""
    for mode in FLASH_MODES:
        options = {'codes': {'port': '1101000'}} if mode == 'coded' else {}
        segmenter = Segmenter(flash=flash_by_name(mode, frequency=15.0, **options))
        for frame, _ in frames(WALL, never)[:40]:
            segmenter.update(frame, Expectation(*never(0), TIGHT))
        assert segmenter.detections is not None
        heeds = mode in ('alternate', 'auto')  # which begins as alternate
        assert (segmenter.detections.region == whole((240, 320))) is not heeds
