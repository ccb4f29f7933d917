"""Line jitter from simulated frames of an edge, against the offsets that were put in."""

from __future__ import annotations

from collections.abc import Iterator

from blob_tracker.calibration.edge import edge_places, EdgeError, find_edge
from blob_tracker.calibration.line_jitter import measure_line_jitter
from blob_tracker.simulation import expose
from blob_tracker.simulation.line_jitter import draw_edge, line_offsets, REMAINDER_PX
from blob_tracker.types import Pixels, SensorNoise
import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.stats import chi2

DRAWS = 100
NOISE = SensorNoise(gain=40.0, read_noise=0.7)
HEIGHT, WIDTH = 80, 64
LEANING = 30.0 + 0.03 * np.arange(HEIGHT, dtype=float)  # px
OFFSETS = line_offsets(HEIGHT)


def straightened(offsets: NDArray[np.float64]) -> NDArray[np.float64]:
    """Take the straight line off, which no edge tells of."""
    lines = np.arange(len(offsets))
    return np.asarray(offsets - np.polyval(np.polyfit(lines, offsets, 1), lines))


def frames(
    random: np.random.Generator,
    *,
    count: int = 6,
    jitter: float = REMAINDER_PX,
    sigma: float = 1.1,
    dark: float = 30.0,
    bright: float = 200.0,
) -> Iterator[Pixels]:
    """Yield frames of an edge that trembles as a whole and jitters in each line."""
    for _ in range(count):
        places = LEANING + OFFSETS + random.normal(0.0, 0.2)
        places = places + np.linspace(0.0, random.normal(0.0, 0.1), HEIGHT)
        places = places + jitter * random.standard_normal(HEIGHT)
        yield expose(draw_edge((HEIGHT, WIDTH), places, sigma, dark, bright), NOISE, random)


@pytest.mark.parametrize('jitter', [0.0, REMAINDER_PX])
def test_truth_is_within_the_stated_sigma(jitter: float) -> None:
    """Chi-square of all lines, and the jitter from frame to frame, over 100 draws."""
    random = np.random.default_rng(3)
    squares, remainders = [], []
    for _ in range(DRAWS):
        found = measure_line_jitter(frames(random, jitter=jitter))
        error = found.jitter.offsets - straightened(OFFSETS)
        squares.append(np.sum((error / found.jitter.sigma) ** 2))
        remainders.append(found.jitter.sigma_from_frame_to_frame)
        assert found.measured.all()
    degrees = HEIGHT - 2  # the straight line
    low, high = chi2.ppf([0.025, 0.975], DRAWS * degrees) / DRAWS
    # Each draw's sigma is had from its own scatter of n = 306 values: as the mean of F.
    assert low < np.mean(squares) < high * 1.007
    if jitter:
        # n of them over 100 draws know it to 1 / sqrt(2 n 100), 0.4 %; the fits' noise adds.
        assert np.mean(remainders) == pytest.approx(jitter, rel=0.01)
    else:
        assert np.mean(remainders) < 0.006  # the noise of the fits is 0.02 px


@pytest.mark.parametrize('dark, bright', [(30.0, 200.0), (200.0, 30.0), (5.0, 25.0)])
def test_edges_are_placed_at_the_bound(dark: float, bright: float) -> None:
    """
    The scatter is the Cramer-Rao bound's, the stated variance is the scatter's, no bias.

    The bound is that of place, both levels and shot noise; the width is known from all lines.
    """
    random = np.random.default_rng(4)
    sigma, step = 1.1, 1e-4
    mean = draw_edge((HEIGHT, WIDTH), LEANING, sigma, dark, bright)
    errors, stated = [], []
    for _ in range(60):
        picture = expose(mean, NOISE, random)
        x, variance, _ = edge_places(picture.astype(float), (30.0, 0.03))
        errors.append(x - LEANING)
        stated.append(variance)
    columns = np.rint(LEANING).astype(int)[:, None] + np.arange(-12, 13)
    by = [
        (draw_edge((HEIGHT, WIDTH), LEANING + step, sigma, dark, bright) - mean) / step,
        (mean - dark) / (bright - dark),
        np.ones_like(mean),
    ]
    derivatives = np.stack([np.take_along_axis(each, columns, axis=1) for each in by], axis=2)
    pixel_variance = np.take_along_axis(mean, columns, axis=1) / NOISE.gain
    pixel_variance += NOISE.read_noise**2 + 1.0 / 12.0
    information = np.einsum('hkp,hk,hkq->hpq', derivatives, 1.0 / pixel_variance, derivatives)
    bound = np.linalg.inv(information)[:, 0, 0].mean()
    seen = np.mean(np.square(errors))
    # 4800 places know their variance to 2 %; three of that.
    assert seen == pytest.approx(bound, rel=0.06)
    assert np.mean(stated) == pytest.approx(seen, rel=0.06)
    assert abs(np.mean(errors)) < 4.0 * np.sqrt(bound / 4800)


def test_the_two_fields_keep_their_own_offset() -> None:
    """The second field is 0.1 px to the right; its lines say so, and no line of the first."""
    random = np.random.default_rng(5)
    offsets = line_offsets(HEIGHT, between_fields=0.1)
    pictures = [
        expose(draw_edge((HEIGHT, WIDTH), LEANING + offsets, 1.1, 30.0, 200.0), NOISE, random)
        for _ in range(8)
    ]
    found = measure_line_jitter(pictures).jitter
    apart = found.offsets[1::2].mean() - found.offsets[::2].mean()
    # 40 lines of 8 frames at 0.02 px are known to 0.001 px; a line over all takes 0.0006 off.
    assert apart == pytest.approx(0.1, abs=0.006)


def test_fields_that_tremble_by_themselves_jitter_no_more() -> None:
    """They are taken one after the other; what is left in their distance is in its sigma."""
    random = np.random.default_rng(11)
    errors, remainders = [], []
    for _ in range(30):
        pictures = []
        for _ in range(6):
            places = LEANING + OFFSETS + REMAINDER_PX * random.standard_normal(HEIGHT)
            for field in range(2):
                places[field::2] += random.normal(0.0, 0.2)
            pictures.append(
                expose(draw_edge((HEIGHT, WIDTH), places, 1.1, 30.0, 200.0), NOISE, random))
        jitter = measure_line_jitter(pictures).jitter
        error = jitter.offsets - straightened(OFFSETS)
        errors.append((error[1::2].mean() - error[::2].mean()) / jitter.sigma_between_fields)
        remainders.append(jitter.sigma_from_frame_to_frame)
    # n of them know it to 1 / sqrt(2 n 30), 0.7 %.
    assert np.mean(remainders) == pytest.approx(REMAINDER_PX, rel=0.03)
    # Student's t with 5 degrees of freedom: the mean of its square is 5/3, give or take 0.7.
    assert 0.6 < np.mean(np.square(errors)) < 4.0


def test_missing_and_marked_lines_are_interpolated_in_their_field() -> None:
    """A label over some lines and a notch in one; wild lines of single frames do no harm."""
    random = np.random.default_rng(6)
    pictures = list(frames(random, count=12))
    for index, picture in enumerate(pictures):
        picture[40:46] = 90
        picture[70] = np.roll(picture[70], 1)  # a notch of the edge in every frame
        picture[20 + index] = np.roll(picture[20 + index], 2)  # lost synchronisation, once
    found = measure_line_jitter(pictures)
    assert set(np.flatnonzero(~found.measured)) == {*range(40, 46), 70}
    error = found.jitter.offsets - straightened(OFFSETS)
    assert np.isfinite(error).all()
    assert (np.abs(error) < 5.0 * found.jitter.sigma).all()
    assert found.jitter.sigma[42] > 1.3 * np.median(found.jitter.sigma)
    assert found.jitter.sigma_from_frame_to_frame == pytest.approx(REMAINDER_PX, rel=0.1)


def test_lines_that_jitter_together_are_found_out() -> None:
    """Neighbours of a field that share most of their jitter."""
    random = np.random.default_rng(7)
    pictures = []
    for _ in range(12):
        walk = np.repeat(random.standard_normal(HEIGHT // 8 + 1), 8)[:HEIGHT]
        places = LEANING + OFFSETS + 0.1 * walk
        pictures.append(expose(draw_edge((HEIGHT, WIDTH), places, 1.1, 30, 200), NOISE, random))
    assert measure_line_jitter(pictures).between_neighbours > 0.5
    independent = measure_line_jitter(frames(random, count=12))
    assert abs(independent.between_neighbours) < 0.15


def test_find_edge_is_good_to_a_pixel() -> None:
    """In noise, and with a bright spot beside it."""
    picture = next(frames(np.random.default_rng(8))).astype(float)
    picture[50:54, 5:9] = 255.0
    start, slope = find_edge(picture)
    assert start + slope * 40 == pytest.approx(LEANING[40] + OFFSETS[40], abs=1.0)
    assert slope == pytest.approx(0.03, abs=0.01)


def noise_only() -> list[NDArray[np.float64]]:
    """Return frames without an edge."""
    return list(np.random.default_rng(9).normal(50.0, 5.0, (5, HEIGHT, WIDTH)))


def leaning(slope: float, middle: float = 32.0) -> list[NDArray[np.float64]]:
    """Return frames of an edge with a slope."""
    places = middle + slope * (np.arange(HEIGHT, dtype=float) - HEIGHT / 2)
    return [draw_edge((HEIGHT, WIDTH), places, 1.0, 30.0, 200.0)] * 4


@pytest.mark.parametrize(
    'pictures, sentence',
    [
        ([], 'there are 0 frames; line jitter needs 4'),
        (list(frames(np.random.default_rng(1), count=3)), 'there are 3 frames'),
        ([np.full((HEIGHT, WIDTH), 7.0)] * 5, 'flat: it shows no edge'),
        ([np.full((HEIGHT, WIDTH), np.nan)] * 5, 'NaN'),
        ([np.zeros((10, WIDTH))] * 5, '24 x 24 px or more'),
        (noise_only(), 'on one straight line'),
        (leaning(0.0, middle=8.0), 'keep it 12 px from the sides'),
        (leaning(0.55), 'turn it upright'),
        ([*leaning(0.0), np.zeros((HEIGHT, WIDTH + 1))], 'must be of one camera'),
    ],
)
def test_what_cannot_be_is_refused(pictures: list, sentence: str) -> None:
    """Each with its sentence."""
    with pytest.raises(EdgeError, match=sentence):
        measure_line_jitter(pictures)
