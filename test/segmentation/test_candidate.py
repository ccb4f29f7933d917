"""What lights up beside the target and is not it: refused with its reason, the target found."""

from __future__ import annotations

from collections.abc import Callable

from blob_tracker.segmentation import Segmenter
from blob_tracker.segmentation.candidate import suppress_connected
from blob_tracker.simulation import expose, FlashingLight, pixel_integrated_gaussian
from blob_tracker.types import Frame, SensorNoise, Window
import cv2
import numpy as np
import pytest

SHAPE = (240, 320)
NOISE = SensorNoise(gain=40.0, read_noise=0.7)
X, Y = 230.3, 160.6  # of the target
Scene = Callable[[np.ndarray, np.ndarray], None]


def blob(x: float, y: float, sigma: float) -> np.ndarray:
    """Return a blob of height 1."""
    return pixel_integrated_gaussian(SHAPE, x, y, sigma)


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
    for index, mean in enumerate((unlit, lit)):
        window = segmenter.update(Frame(expose(mean, NOISE, random), 1 + index * 10**7, 255))
    return window, segmenter.reason


@pytest.mark.parametrize('scene', CLUTTER)
@pytest.mark.parametrize('seed', range(3))
def test_clutter_alone_gives_no_window(scene: Scene, seed: int) -> None:
    """And a reason."""
    window, reason = segmented(scene, 0.0, seed)
    assert window is None
    assert reason


@pytest.mark.parametrize('scene', CLUTTER)
@pytest.mark.parametrize('seed', range(3))
def test_the_target_is_found_beside_clutter(scene: Scene, seed: int) -> None:
    """Though the clutter rises higher than it."""
    window, reason = segmented(scene, 60.0, seed)
    if window is None and scene is rolling_band:
        # A band over an eighth of the frame counts as noise; the pair may be given up.
        assert reason
        return
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


def test_of_two_flashes_the_greater_snr_is_taken() -> None:
    """A small bright one and a wide one of a lower peak: the wide one has more light."""
    def small_flash(unlit: np.ndarray, lit: np.ndarray) -> None:
        lit += 90 * blob(80, 60, 1.0)

    window, _ = segmented(small_flash, 80.0, 1)
    assert window is not None and window.x0 > 200


@pytest.mark.parametrize('sigma', [0.6, 1.0, 2.0, 5.0])
def test_a_faint_target_on_texture_is_not_refused(sigma: float) -> None:
    """At a peak SNR of 10, texture four times the noise: 1 of 200 at most is missed."""
    scene = FlashingLight(width=320, height=240)
    random = np.random.default_rng(7)
    noise = np.sqrt(2 * (40 / 40 + 0.7**2 + 1 / 12))
    missed = 0
    for _ in range(200):
        x, y = random.uniform(40, 280), random.uniform(40, 200)
        segmenter = Segmenter()
        # The brightest pixel of a small blob has less than its peak, by the pixel's own width.
        light = blob(round(x), round(y), sigma)
        lit = scene.wall + 10 * noise / light.max() * light
        segmenter.update(Frame(expose(scene.wall, scene.noise, random), 1, 255))
        window = segmenter.update(Frame(expose(lit, scene.noise, random), 10**7, 255))
        missed += window is None
    # 10 sigma above a threshold of 8 leaves what the noise and the sub-pixel phase take: 1 %.
    assert missed <= 1


@pytest.mark.parametrize('kind', [np.uint8, np.uint16])
def test_a_connected_rise_is_suppressed_whole(kind: type) -> None:
    """Across corners, down to the level; what stands apart stays."""
    search = np.zeros((6, 8), kind)
    search[1, 1:4] = search[2, 4] = 50
    search[3, 5] = 9
    search[5, 7] = 40
    suppress_connected(search, 1, 1, 10.0)
    assert np.argwhere(search).tolist() == [[3, 5], [5, 7]]
