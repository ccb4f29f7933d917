"""All that lit up is found, wherever it is and however many it is, in 8 and in 16 bits."""

from __future__ import annotations

from blob_tracker.segmentation import Segmenter
from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.simulation import expose, flashing_light, pixel_integrated_gaussian
from blob_tracker.types import Frame, SensorNoise
import numpy as np
import pytest
from support.contrasts import contrast_of, DEVIATION, noisy_blob, READ_NOISE, searched

SHAPE = (240, 320)
PLACES = ((60.3, 50.6, 1.2), (160.8, 120.1, 2.0), (250.4, 190.7, 4.0))  # x, y, sigma, px


def lights(
    places: tuple[tuple[float, float, float], ...] = PLACES,
    amplitude: float = 100.0,
    *,
    scale: int = 1,
    background: np.ndarray | None = None,
    seed: int = 1,
) -> Contrast:
    """Return blobs of one height on an even level, or on this."""
    unlit = np.full(SHAPE, 40.0) if background is None else background
    lit = unlit + sum(
        amplitude * pixel_integrated_gaussian(SHAPE, x, y, sigma) for x, y, sigma in places
    )
    random = np.random.default_rng(seed)
    seen, before = (expose(mean, READ_NOISE, random) for mean in (lit, unlit))
    if scale > 1:
        seen, before = (each.astype(np.uint16) * np.uint16(scale) for each in (seen, before))
    return contrast_of(seen, before)


def test_each_light_is_measured() -> None:
    """Place, width, height, amplitude and noise of three blobs, and nothing else."""
    found = searched(lights())
    assert found.reason == ''
    # 12 tiles of a noise that each knows to 4 %; whole levels take a part of a DN.
    assert found.noise == pytest.approx(DEVIATION, rel=0.1)
    assert found.background == pytest.approx(0.0, abs=0.3)
    assert len(found.candidates) == 3
    heights = [each.height for each in found.candidates]
    assert heights == sorted(heights, reverse=True)
    assert found.strongest == pytest.approx(heights[0], abs=1e-9)
    for x, y, sigma in PLACES:
        near, = (each for each in found.candidates if np.hypot(each.x - x, each.y - y) < 0.2)
        assert near.rejected == ''
        assert near.sigma_x == pytest.approx(np.hypot(sigma, 0.29), rel=0.05)
        # The brightest of some pixels is one or two of its noise too high, and less than the peak.
        assert near.height == pytest.approx(95.0, abs=8.0)
        assert near.amplitude == pytest.approx(97.0, abs=4.0)
        assert abs(near.column - x) <= 0.2 + sigma and abs(near.row - y) <= 0.2 + sigma
        # Each of 49 pixels or more leaves its noise; the blob is one.
        assert near.misfit < 0.1 and near.neighbour_ratio > 0.3 and not near.clipped
        assert near.fall < 4.0 * DEVIATION
        assert abs(near.unlit_amplitude) < 2.0


def test_sixteen_bits_are_searched_as_eight() -> None:
    """The same pixels times 257: all in DN is 257 times as much, all in px the same."""
    eight, sixteen = (searched(lights(scale=scale)).candidates for scale in (1, 257))
    assert len(sixteen) == len(eight) == 3
    for narrow, wide in zip(eight, sixteen, strict=True):
        assert (wide.x, wide.y) == pytest.approx((narrow.x, narrow.y), abs=1e-3)
        assert wide.sigma_x == pytest.approx(narrow.sigma_x, rel=1e-3)
        assert wide.height == pytest.approx(257 * narrow.height, rel=1e-3)
        assert wide.amplitude == pytest.approx(257 * narrow.amplitude, rel=1e-3)
        assert wide.snr == pytest.approx(narrow.snr, rel=1e-2)


def test_only_the_region_is_searched() -> None:
    """Places are those of the frame all the same."""
    found = searched(lights(), Box(120, 90, 201, 151))
    assert len(found.candidates) == 1
    assert found.candidates[0].x == pytest.approx(160.8, abs=0.1)
    assert searched(lights(), Box(0, 0, 120, 30)).candidates == ()


@pytest.mark.parametrize('region', [
    Box(5, 5, 5, 5), Box(0, 0, 4, 200), Box(10, 10, 15, 15), Box(300, 220, 320, 240),
    Box(0, 0, 320, 5), Box(0, 0, 1, 1),
])
def test_odd_regions_hold_nothing(region: Box) -> None:
    """As small as they come."""
    assert searched(lights(), region).candidates == ()


def test_a_mask_hides_what_is_in_it() -> None:
    """The peak decides."""
    mask = np.ones(SHAPE, np.uint8)
    mask[100:140, 140:180] = 0
    assert sorted(round(each.x) for each in searched(lights(), mask=mask).candidates) == [60, 250]
    assert searched(lights(), mask=np.zeros(SHAPE, np.uint8)).candidates == ()


def test_a_light_that_went_out_is_none() -> None:
    """The difference has a sign."""
    contrast = lights()
    swapped = searched(contrast_of(contrast.unlit, contrast.lit))
    assert [each for each in swapped.candidates if not each.rejected] == []


@pytest.mark.parametrize('sigma', [2.0, 6.0])
def test_a_clipped_plateau_is_one_candidate(sigma: float) -> None:
    """Three times full scale: its many equal pixels are one peak, in the middle of it."""
    contrast = lights(((160.0, 120.0, sigma),), 645.0)
    found, = (each for each in searched(contrast).candidates if not each.rejected)
    assert (found.x, found.y) == pytest.approx((160.0, 120.0), abs=0.1)
    assert contrast.lit[int(found.row), int(found.column)] == 255


@pytest.mark.parametrize('sigma', [0.6, 1.0, 3.0, 8.0, 15.0, 25.0, 40.0])
def test_a_blob_of_any_width_is_one_candidate(sigma: float) -> None:
    """Its other peaks, by noise, are its own flanks."""
    contrast = noisy_blob((480, 640), 320.3, 240.4, sigma, 120.0)
    allowed = [each for each in searched(contrast).candidates if not each.rejected]
    assert len(allowed) == 1
    assert np.hypot(allowed[0].x - 320.3, allowed[0].y - 240.4) < 0.1 * max(sigma, 1.0)


def test_a_target_in_a_band_is_found() -> None:
    """A band of 30 rows brightened by as much as the noise of twenty."""
    contrast = lights()
    lit = contrast.lit.copy()
    lit[105:135] += 30
    found = searched(contrast._replace(lit=lit))
    assert any(np.hypot(each.x - 160.8, each.y - 120.1) < 0.5 for each in found.candidates)


def test_noise_alone_gives_no_candidate() -> None:
    """One of 20 frames at most: a peak and a matched filter of 7 must be made by it."""
    found = [searched(lights((), seed=seed)).candidates for seed in range(20)]
    assert sum(len(each) for each in found) <= 1


@pytest.mark.parametrize('count', [100, 1100])
def test_more_lights_than_there_is_room_for(count: int) -> None:
    """A hundred are all found; of eleven hundred, most of those that there is room for."""
    random = np.random.default_rng(3)
    side = int(np.ceil(np.sqrt(count)))
    height = width = 24 * side
    lit = np.full((height, width), 20.0)
    places = []
    for k in range(count):
        x, y = 12 + 24 * (k % side), 12 + 24 * (k // side)
        places.append((x, y))
        lit[y - 8:y + 9, x - 8:x + 9] += 120 * pixel_integrated_gaussian((17, 17), 8, 8, 1.0)
    unlit = np.full_like(lit, 20.0)
    seen, before = (expose(each, READ_NOISE, random) for each in (lit, unlit))
    found = searched(contrast_of(seen, before))
    # Of too many peaks the flanks take some of the room.
    assert len(found.candidates) == count if count < 1024 else 900 < len(found.candidates) <= 1024
    for each in found.candidates:
        assert min(np.hypot(each.x - x, each.y - y) for x, y in places) < 0.5


def test_the_brightest_are_kept_of_too_many_peaks() -> None:
    """White noise of full height has more peaks than there is room for; a light stands out."""
    random = np.random.default_rng(4)
    unlit = np.full((480, 640), 20, np.uint8)
    lit = unlit.copy()
    hot = random.random(lit.shape) < 0.03  # 9000 pixels that rose
    lit[hot] = random.integers(40, 90, int(hot.sum()))
    contrast = contrast_of(lit, unlit)
    light = 200.0 * pixel_integrated_gaussian(lit.shape, 320.3, 240.4, 2.0)
    contrast = contrast._replace(lit=np.clip(lit + light, 0, 255).astype(np.uint8))
    found = searched(contrast)
    assert len(found.candidates) <= 1024
    assert np.hypot(found.candidates[0].x - 320.3, found.candidates[0].y - 240.4) < 1.0


@pytest.mark.parametrize('sigma', [0.6, 1.0, 2.0, 5.0])
def test_a_faint_target_on_texture_is_not_refused(sigma: float) -> None:
    """At a peak SNR of 10, texture four times the noise: 4 of 200 at most look like an edge."""
    scene = flashing_light(width=320, height=240)
    random = np.random.default_rng(7)
    noise = np.sqrt(2 * (40 / 40 + 0.7**2 + 1 / 12))
    missed = 0
    for _ in range(200):
        x, y = random.uniform(40, 280), random.uniform(40, 200)
        # The brightest pixel of a small blob has less than its peak, by the pixel's own width.
        light = pixel_integrated_gaussian(SHAPE, round(x), round(y), sigma)
        lit = scene.wall + 10 * noise / light.max() * light
        seen, before = (expose(mean, scene.sensor.noise, random) for mean in (lit, scene.wall))
        found = searched(contrast_of(seen, before))
        missed += not any(
            not each.rejected and np.hypot(each.x - round(x), each.y - round(y)) < 2.0 + sigma
            for each in found.candidates
        )
    assert missed <= 4


def test_a_faint_blob_is_looked_at_twice_about_a_prediction() -> None:
    """At a peak SNR of 2 and a width of 3 px few pixels stand out; the matched filter has 11."""
    seen = {True: 0, False: 0}
    for seed in range(10):
        contrast = noisy_blob((480, 640), 320.3, 240.4, 3.0, 2.0 * DEVIATION, seed=seed)
        for followed in seen:
            found = searched(contrast, Box(290, 210, 351, 271), followed=followed)
            seen[followed] += len(found.candidates) > 0
    assert seen[True] >= 9
    assert seen[False] <= 0.7 * seen[True]


def test_an_exposure_jump_is_named() -> None:
    """A change of the whole by half, up or down, beside which no light is bright."""
    contrast = lights(amplitude=30.0)
    for lit, unlit in ((contrast.lit, contrast.unlit // 2), (contrast.unlit // 2, contrast.lit)):
        found = searched(contrast_of(lit, unlit))
        assert 'the whole scene changed by' in found.reason
        assert 'switch auto-exposure off' in found.reason


def test_a_change_that_is_no_gain_is_not_laid_to_exposure() -> None:
    """A lamp lights the upper half alone."""
    contrast = lights(amplitude=30.0)
    lit = contrast.unlit.copy()
    lit[:lit.shape[0] * 3 // 5] *= 3
    reason = searched(contrast_of(lit, contrast.unlit)).reason
    assert 'the whole scene changed by' in reason
    assert 'auto-exposure' not in reason
    assert 'not all of it by the same factor' in reason


@pytest.mark.parametrize('kind', ['read-only', 'every other column', 'transposed', 'reversed'])
def test_frames_in_any_memory_are_taken(kind: str) -> None:
    """A message's buffer cannot be written to, a cut-out is not contiguous."""
    scene = flashing_light(width=160, height=120, period=3.0)

    def stored(image: np.ndarray) -> np.ndarray:
        if kind == 'every other column':
            wide = np.zeros((120, 320), np.uint8)
            wide[:, ::2] = image
            return wide[:, ::2]
        if kind == 'transposed':
            return np.ascontiguousarray(image.T).T
        if kind == 'reversed':
            return np.ascontiguousarray(image[::-1])[::-1]
        image.flags.writeable = False
        return image

    segmenter, plain = Segmenter(), Segmenter()
    for index in range(1, 7):
        image = scene.frame(index)
        expected = plain.update(Frame(image.copy(), 1 + index * 10**7, 255))
        window = segmenter.update(Frame(stored(image), 1 + index * 10**7, 255))
        assert (window is None) is (expected is None)
        if window is not None:
            np.testing.assert_array_equal(window.lit, expected.lit)
            np.testing.assert_array_equal(window.unlit, expected.unlit)
    assert window is not None


def test_shot_noise_of_a_bright_part_is_its_own() -> None:
    """The noise is that of the tile: five times as bright, and no more peaks in it."""
    random = np.random.default_rng(5)
    mean = np.full((256, 512), 20.0)
    mean[:, 256:] = 200.0
    noise = SensorNoise(gain=2.0, read_noise=0.5)
    seen, before = (expose(mean, noise, random) for _ in range(2))
    found = searched(contrast_of(seen, before))
    assert found.candidates == ()
