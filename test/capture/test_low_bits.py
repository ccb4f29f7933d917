"""Words of 16 bits whose samples have fewer, from their pixels."""

from __future__ import annotations

from blob_tracker.capture.low_bits import FRAMES, FULL, LowBits
import numpy as np
import pytest

RANDOM = np.random.default_rng(5)


def samples(bits: int, level: float = 100.0) -> np.ndarray:
    """Return a dim picture with noise of 3 DN, and a clipped pixel, of so many bits."""
    image = RANDOM.normal(level, 3.0, (48, 64)).round().clip(0).astype(np.uint16)
    image[5, 7] = (1 << bits) - 1
    return image << (16 - bits)


@pytest.mark.parametrize(('bits', 'saturation'), [
    (8, 0xff00), (10, 0xffc0), (12, 0xfff0), (14, 0xfffc), (16, 0xffff),
])
def test_a_clipped_pixel_is_at_the_saturation(bits, saturation):
    image = samples(bits)
    assert LowBits().saturation(image) == saturation == image.max()


def test_a_picture_without_light_says_nothing():
    seen = LowBits()
    assert seen.saturation(np.zeros((4, 4), np.uint16)) == FULL
    assert seen.saturation(np.full((4, 4), 4096, np.uint16)) == FULL  # a pedestal without noise
    assert seen.saturation(samples(12)) == 0xfff0
    # A sensor of 16 bits whose first pictures happened to be even.
    assert seen.saturation(samples(16)) == FULL


def test_pairs_of_green_samples_lose_a_bit():
    image = samples(12).astype(int)
    pairs = ((image[:, ::2] + image[:, 1::2]) // 2).astype(np.uint16)
    assert LowBits(binning=2).saturation(pairs) == 0xfff0


def test_it_looks_at_the_first_pictures_alone():
    seen = LowBits()
    for _ in range(FRAMES):
        seen.saturation(samples(12))
    assert seen.saturation(samples(16)) == 0xfff0
