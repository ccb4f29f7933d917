"""The scene: light on in even frames at its true place, the same bits for the same seed."""

import dataclasses

from blob_tracker.simulation import flashing_light, Sensor
from blob_tracker.types import SensorNoise
import numpy as np

SCENE = flashing_light(width=160, height=120)
QUIET = dataclasses.replace(
    SCENE,
    texture=0.0,
    background=0.0,
    sensor=Sensor(SensorNoise(gain=np.inf, read_noise=0.0)),
)


def test_same_seed_same_bits_in_any_order() -> None:
    """A frame depends on its index and the seed alone."""
    again = flashing_light(width=160, height=120)
    backwards = {index: again.frame(index) for index in (7, 4, 0)}
    for index, image in backwards.items():
        np.testing.assert_array_equal(SCENE.frame(index), image)
    other = dataclasses.replace(SCENE, seed=2)
    assert (other.frame(4) != SCENE.frame(4)).any()


def test_light_stands_where_the_truth_says() -> None:
    """Without noise the centre of gravity is the truth, within the rounding of the pixels."""
    rows, columns = np.mgrid[:120, :160]
    for index in range(0, 40, 2):
        image = QUIET.frame(index).astype(float)
        truth = QUIET.truth(index)
        assert truth.lit
        # Rounding of about 100 pixels of 0.29 DN over 3770 DN in all, at 4 px: below 0.01 px.
        assert abs((image * columns).sum() / image.sum() - truth.x) < 0.01
        assert abs((image * rows).sum() / image.sum() - truth.y) < 0.01


def test_odd_frames_are_dark() -> None:
    """The light is off in them."""
    assert not QUIET.truth(3).lit
    assert QUIET.frame(3).max() == 0


def test_path_leaves_the_frame_without_harm() -> None:
    """A light beyond the border is cut off, not wrapped around."""
    far = flashing_light(width=160, height=120, reach=1.3).target
    wide = dataclasses.replace(QUIET, target=far)
    for index in range(0, 540, 2):
        truth = wide.truth(index)
        image = wide.frame(index)
        if not (-20 < truth.x < 180 and -20 < truth.y < 140):
            assert image.max() == 0
