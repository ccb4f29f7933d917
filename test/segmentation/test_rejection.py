"""What lights up beside the target and is not it: rejected with its reason, its twin is not."""

from __future__ import annotations

from collections.abc import Callable
import re

from blob_tracker.segmentation import Candidate, Segmenter
from blob_tracker.segmentation.rejection import fault, FIELDS, in_words
from blob_tracker.simulation import expose, pixel_integrated_gaussian
from blob_tracker.types import Frame, SensorNoise, Window
import cv2
import numpy as np
import pytest
from support.contrasts import candidate_at, contrast_of, searched

SHAPE = (240, 320)
NOISE = SensorNoise(gain=40.0, read_noise=0.7)
X, Y = 230.3, 160.6  # of the target
Scene = Callable[[np.ndarray, np.ndarray], None]


def blob(x: float, y: float, sigma: float, sigma_y: float | None = None) -> np.ndarray:
    """Return a blob of height 1."""
    return pixel_integrated_gaussian(SHAPE, x, y, sigma, sigma_y)


def why(candidate: Candidate, *, followed: bool = False) -> str:
    """Say why it is no target; empty where nothing speaks against it."""
    return in_words(fault(np.array(candidate[:FIELDS]), followed, 0.0), candidate)


def hot_pixel(unlit: np.ndarray, lit: np.ndarray) -> None:
    """Let one pixel jump."""
    lit[60, 80] += 190


def moving_edge(unlit: np.ndarray, lit: np.ndarray) -> None:
    """Let a bright wall, slanted, come three pixels further into the picture."""
    rows, columns = np.mgrid[:SHAPE[0], :SHAPE[1]]
    for image, place in ((unlit, 90), (lit, 93)):
        image += 150 * (columns + 0.4 * rows < place)


def flickering_lamp(unlit: np.ndarray, lit: np.ndarray) -> None:
    """Let a lamp on the mains give 15 % more light in the lit frame."""
    unlit += 170 * blob(80, 60, 3.0)
    lit += 195 * blob(80, 60, 3.0)


def moving_glint(unlit: np.ndarray, lit: np.ndarray) -> None:
    """Let a small bright spot go from one place to the next."""
    unlit += 200 * blob(80, 60, 1.2)
    lit += 200 * blob(84, 62, 1.2)


def rolling_band(unlit: np.ndarray, lit: np.ndarray) -> None:
    """Brighten by lamps on the mains thirty rows of the lit frame."""
    lit[40:70] += 60


def sun(unlit: np.ndarray, lit: np.ndarray) -> None:
    """Move a clipped disc of 25 px by two pixels."""
    for image, x in ((unlit, 80), (lit, 82)):
        image += 2000 * cv2.circle(np.zeros(SHAPE), (x, 60), 25, 1.0, -1)


CLUTTER = [hot_pixel, moving_edge, flickering_lamp, moving_glint, rolling_band, sun]


def segmented(scene: Scene, amplitude: float, seed: int) -> tuple[Window | None, str]:
    """Return the window, and the reason, of a pair with this clutter and a target."""
    random = np.random.default_rng(seed)
    unlit, lit = np.full(SHAPE, 30.0), np.full(SHAPE, 30.0)
    scene(unlit, lit)
    lit += amplitude * blob(X, Y, 2.0)
    segmenter = Segmenter()
    window = None
    # Four flashes: beside a band, more things light up than a target.
    for index, mean in enumerate(4 * (unlit, lit)):
        window = segmenter.update(Frame(expose(mean, NOISE, random), 1 + index * 10**7, 255))
    return window, segmenter.reason


@pytest.mark.parametrize('scene', CLUTTER)
@pytest.mark.parametrize('seed', range(3))
def test_clutter_alone_gives_no_window(scene: Scene, seed: int) -> None:
    """And a reason, though it comes and goes in step with the frames."""
    window, reason = segmented(scene, 0.0, seed)
    assert window is None
    assert reason


@pytest.mark.parametrize('scene', CLUTTER)
@pytest.mark.parametrize('seed', range(3))
def test_the_target_is_found_beside_clutter(scene: Scene, seed: int) -> None:
    """Though the clutter rises higher than it."""
    window, reason = segmented(scene, 60.0, seed)
    assert window is not None, reason
    height, width = window.lit.shape
    assert abs(window.x0 + (width - 1) / 2 - X) <= 1.5
    assert abs(window.y0 + (height - 1) / 2 - Y) <= 1.5


@pytest.mark.parametrize('scene, words', [
    (hot_pixel, 'a lone pixel rose'),
    (flickering_lamp, 'a lamp that flickers'),
    (moving_glint, 'something moved'),
])
def test_the_reason_names_the_clutter(scene: Scene, words: str) -> None:
    """So that an operator knows what to cover."""
    assert words in segmented(scene, 0.0, 1)[1]


def one(unlit: np.ndarray, lit: np.ndarray) -> Candidate:
    """Return the highest of what lit up near (80, 60)."""
    random = np.random.default_rng(1)
    found = searched(contrast_of(expose(lit, NOISE, random), expose(unlit, NOISE, random)))
    near = [each for each in found.candidates if abs(each.x - 80) < 20 and abs(each.y - 60) < 20]
    return near[0]


def even() -> np.ndarray:
    """Return a scene of 30 DN."""
    return np.full(SHAPE, 30.0)


def pixel_of(neighbour_ratio: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a pixel that rose by 150 DN, and its four neighbours by a part of it."""
    lit = even()
    lit[60, 80] += 150
    for row, column in ((59, 80), (61, 80), (60, 79), (60, 81)):
        lit[row, column] += 150 * neighbour_ratio
    return even(), lit


def bar_of(length: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a rise that is longer than wide, and slanted."""
    y, x = np.mgrid[:SHAPE[0], :SHAPE[1]]
    along, across = (x - 80.3 + y - 60.2) / np.sqrt(2), (y - 60.2 - x + 80.3) / np.sqrt(2)
    return even(), even() + 100 * np.exp(-0.5 * ((along / length) ** 2 + (across / 2.0) ** 2))


def light_that_moved(part: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a light that came, and one of this part of its height that went beside it."""
    return even() + 100 * part * blob(89.0, 62.0, 2.0), even() + 100 * blob(80.3, 60.2, 2.0)


def ring_of(radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a rise on a ring."""
    y, x = np.mgrid[:SHAPE[0], :SHAPE[1]]
    return even(), even() + 100 * np.exp(-((np.hypot(x - 80.3, y - 60.2) - radius) / 3.0) ** 2)


def arc_of(radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a rise on half a ring."""
    unlit, lit = ring_of(radius)
    y, x = np.mgrid[:SHAPE[0], :SHAPE[1]]
    missing = x + y > 140.5
    return unlit, np.where((radius > 0.0) & missing, unlit, lit)


def streak_of(length: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a light that was dragged along a slanted line."""
    way = np.linspace(-0.5, 0.5, 101)[:, None] * length / np.sqrt(2)
    return even(), even() + 100 * np.mean([
        blob(80.3 + along, 60.2 + along, 1.5) for along in way[:, 0]
    ], axis=0) * max(length / 4.0, 1.0)


def lamp_of(standing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a rise of 60 DN on a light that was there before."""
    light = blob(80.3, 60.2, 2.5)
    return even() + standing * light, even() + (standing + 60) * light


def beside_the_clipped(level: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a blob beside a few pixels of this level."""
    unlit = even()
    unlit[57:59, 83:85] = level
    return unlit, unlit + 40 * blob(80.3, 60.2, 2.0)


@pytest.mark.parametrize('make, target, clutter, words', [
    # The four neighbours of a blob of 0.6 px have 0.3 of its peak.
    (pixel_of, 0.3, 0.0, r'a lone pixel rose by 1\d\d DN'),
    (bar_of, 4.0, 9.0, r'\d.\d px long and \d.\d px wide'),
    (light_that_moved, 0.3, 0.8, 'something moved, or the light was on in both frames'),
    (arc_of, 0.0, 10.0, 'that is not a blob: a Gaussian leaves'),
    (lamp_of, 40.0, 100.0, r'on \d+ DN that were there before: a lamp that flickers'),
    (beside_the_clipped, 120.0, 300.0, 'clipped before: the rim of the sun'),
], ids=['hot pixel', 'edge', 'moving light', 'arc', 'lamp', 'rim'])
def test_each_rule_has_its_pixels(make, target: float, clutter: float, words: str) -> None:
    """The same pixels, but for what the rule asks for, may be a target."""
    assert one(*make(target)).rejected == ''
    found = one(*make(clutter))
    assert found.rejected
    assert re.search(words, found.rejected), found.rejected


@pytest.mark.parametrize('make, size', [
    (ring_of, 6.0), (ring_of, 10.0), (streak_of, 8.0), (streak_of, 14.0), (streak_of, 20.0),
])
def test_a_light_out_of_focus_or_on_the_move_is_a_target(make, size: float) -> None:
    """It is even about its middle, or has a level and two ends."""
    found = one(*make(size))
    assert found.rejected == ''
    # A window of 3 sigma about it holds all of it.
    assert abs(found.x - 80.3) < 0.5
    assert abs(found.y - 60.2) < 0.5


@pytest.mark.parametrize('changes, words', [
    ({'neighbour_ratio': 0.09}, 'a lone pixel'),
    ({'sigma_major': 5.1}, 'an edge that moved, or a band'),
    ({'fall': 51.0}, 'something moved'),
    ({'misfit': 0.51}, 'not a blob: a Gaussian leaves 51 %'),
    ({'unlit_amplitude': 101.0}, 'a lamp that flickers'),
    ({'clipped': 1.0}, 'the rim of the sun'),
])
def test_each_limit_is_where_it_is_said_to_be(changes: dict[str, float], words: str) -> None:
    """Two hundredths below it nothing is rejected."""
    assert words in why(candidate_at(80, 60, **changes))
    (name, value), = changes.items()
    within = {'neighbour_ratio': 0.11, 'clipped': 0.0}.get(name, 0.98 * value)
    assert why(candidate_at(80, 60, **{name: within})) == ''


def test_noise_and_pixels_are_allowed_for() -> None:
    """A faint blob has falls beside it, a small one no shape, a textured scene heights."""
    faint = candidate_at(80, 60, height=7.0, amplitude=7.0, fall=3.9)
    assert why(faint) == ''
    assert 'beside a fall' in why(faint._replace(fall=4.1))
    small = candidate_at(80, 60, sigma_minor=0.6, sigma_major=1.7, misfit=0.9)
    assert why(small) == ''
    assert 'px long' in why(small._replace(sigma_major=2.2))
    textured = candidate_at(80, 60, unlit_amplitude=140.0, texture=50.0)
    assert why(textured) == ''


def test_a_target_that_is_followed_may_pass_in_front_of_something_bright() -> None:
    """Three times as bright as it."""
    assert why(candidate_at(80, 60, unlit_amplitude=290.0))
    assert why(candidate_at(80, 60, unlit_amplitude=290.0), followed=True) == ''
    assert why(candidate_at(80, 60, unlit_amplitude=310.0), followed=True)
