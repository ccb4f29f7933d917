"""The unlit frame is laid over the lit one to 8 px and 1 degree, and the flash is left."""

from __future__ import annotations

from blob_tracker.location import locate
from blob_tracker.segmentation import Segmenter
from blob_tracker.segmentation.alternate import Alternate
from blob_tracker.segmentation.registration import affine, laid_over, translation
from blob_tracker.simulation import FlashingLight, in_step, Light, Scene, Stepping
from blob_tracker.types import Frame
import numpy as np
import pytest

SCENE = FlashingLight(width=320, height=240, texture=15.0)
STEP_NS = 16_666_667
SHIFTS = [(0.0, 0.0), (2.5, 1.2), (5.0, 0.0), (8.0, -8.0), (-5.7, 5.7)]


def stepping(shift_x: float, shift_y: float, turn: float = 0.0) -> Scene:
    """Return a light before a wall, and a camera that has moved in the lit frames."""
    light = Light(
        159.5, 119.5, 2.0, 150.0, in_step(60.0), reach_x=112.0, reach_y=84.0
    )
    return Scene(
        light, camera=Stepping(shift_x, shift_y, turn), width=320, height=240, texture=15.0
    )


def error(found: np.ndarray, true: np.ndarray) -> float:
    """Return how far the two maps are apart at worst, px, on a grid over the frame."""
    grid = np.array([[x, y, 1.0] for x in (40, 160, 280) for y in (30, 120, 210)]).T
    return float(np.hypot(*(found @ grid - true @ grid)).max())


@pytest.mark.parametrize('shift', SHIFTS)
def test_a_shift_is_found(shift: tuple[float, float]) -> None:
    """Within a fifth of a pixel by phase correlation; a half pixel is its worst case."""
    camera = stepping(*shift)
    found = translation(camera.frame(2), camera.frame(1))
    assert found is not None
    assert error(found, camera.shot(2).motion) < 0.25


@pytest.mark.parametrize('shift', SHIFTS)
@pytest.mark.parametrize('turn', [-1.0, 0.0, 1.0])
def test_a_shift_with_a_turn_is_found(shift: tuple[float, float], turn: float) -> None:
    """Within a tenth of a pixel over the whole frame, in 8 and in 16 bits."""
    camera = stepping(*shift, turn)
    lit, unlit = camera.frame(2), camera.frame(1)
    for scale in (1, 256):
        kind = np.uint8 if scale == 1 else np.uint16
        found = affine(lit.astype(kind) * kind(scale), unlit.astype(kind) * kind(scale))
        assert found is not None
        assert error(found, camera.shot(2).motion) < 0.1


@pytest.mark.parametrize('method', [translation, affine])
def test_nothing_in_common_is_none(method) -> None:
    """Noise against noise, and pictures without texture, are refused."""
    random = np.random.default_rng(4)
    noise = [random.integers(0, 255, (240, 320)).astype(np.uint8) for _ in range(2)]
    assert method(*noise) is None
    flat = np.full((240, 320), 90, np.uint8)
    assert method(flat, flat) is None


def test_where_the_unlit_frame_did_not_reach_nothing_rises() -> None:
    """The strip that came into view is that of the lit frame."""
    lit, unlit = np.full((40, 60), 90, np.uint8), np.full((40, 60), 30, np.uint8)
    laid = laid_over(lit, unlit, np.array([[1.0, 0.0, 5.0], [0.0, 1.0, 0.0]]))
    assert (laid[:, :4] == 90).all()
    assert (laid[:, 7:] == 30).all()


def located(camera: Scene, registration: str, lit: range) -> list[float]:
    """Return the errors in x and y, px, of the pairs that gave a window."""
    errors = []
    for index in lit:
        segmenter = Segmenter(
            flash=Alternate(min_snr=7.0, max_pair_interval=0.1, registration=registration)
        )
        segmenter.update(Frame(camera.frame(index - 1), 1, 255))
        window = segmenter.update(Frame(camera.frame(index), STEP_NS, 255))
        if window is not None:
            found, truth = locate(window, noise=SCENE.noise), camera.truth(index)
            errors += [found.x - truth.x, found.y - truth.y]
    return errors


@pytest.mark.parametrize('registration, camera', [
    ('translation', stepping(5.0, 0.0)),
    ('affine', stepping(3.0, 4.0)),
    ('affine', stepping(8.0, 0.0, 1.0)),
], ids=['translation', 'affine', 'affine with a turn'])
def test_the_light_is_placed_from_a_moving_camera(
    registration: str, camera: Scene
) -> None:
    """Every pair gives a window, and the light is within the thesis' 0.05 px rms."""
    errors = located(camera, registration, range(2, 42, 2))
    assert len(errors) == 2 * 20
    assert np.sqrt(np.mean(np.square(errors))) < 0.05


def test_an_unknown_registration_is_named() -> None:
    """With those that there are."""
    with pytest.raises(ValueError, match="no registration 'best'; there is none, translation"):
        Alternate(min_snr=7.0, max_pair_interval=0.1, registration='best')


def test_frames_with_nothing_in_common_give_a_reason() -> None:
    """A lens cap between two frames."""
    segmenter = Segmenter(
        flash=Alternate(min_snr=7.0, max_pair_interval=0.1, registration='affine')
    )
    segmenter.update(Frame(np.zeros((240, 320), np.uint8), 1, 255))
    assert segmenter.update(Frame(SCENE.frame(2), STEP_NS, 255)) is None
    assert 'too little in common' in segmenter.reason
