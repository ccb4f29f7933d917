"""Binned green: right in every order, unbiased for every colour, and with a true noise model."""

from blob_tracker.capture.pixel_formats import PIXEL_FORMATS
from blob_tracker.location import locate
from blob_tracker.simulation.light import pixel_integrated_gaussian
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import SensorNoise, Window
import numpy as np
import pytest
from scipy.stats import chi2

# Colours of the cell, row by row, and the code of each number of bits.
ORDERS = {
    'BGGR': {8: 'BA81', 10: 'BG10', 12: 'BG12', 14: 'BG14', 16: 'BYR2'},
    'GBRG': {8: 'GBRG', 10: 'GB10', 12: 'GB12', 14: 'GB14', 16: 'GB16'},
    'GRBG': {8: 'GRBG', 10: 'BA10', 12: 'BA12', 14: 'GR14', 16: 'GR16'},
    'RGGB': {8: 'RGGB', 10: 'RG10', 12: 'RG12', 14: 'RG14', 16: 'RG16'},
}
PACKED = {
    'BGGR': ('pBAA', 'pBCC', 'pBEE'), 'GBRG': ('pGAA', 'pGCC', 'pGEE'),
    'GRBG': ('pgAA', 'pgCC', 'pgEE'), 'RGGB': ('pRAA', 'pRCC', 'pREE'),
}


def mosaic(order, red, green, blue):
    """Return the picture whose samples come from three, each by its colour."""
    picture = np.empty_like(green)
    for place, colour in enumerate(order):
        y, x = divmod(place, 2)
        picture[y::2, x::2] = {'R': red, 'G': green, 'B': blue}[colour][y::2, x::2]
    return picture


@pytest.mark.parametrize('order', ORDERS)
@pytest.mark.parametrize('bits', [8, 10, 12, 14, 16])
def test_green_alone_is_summed(decode, order, bits):
    full = (1 << bits) - 1
    red, blue = np.full((2, 6, 8), full, np.uint16)
    green = np.random.default_rng(4).integers(0, full, (6, 8), np.uint16)
    green[2, 4:6] = green[3, 4:6] = 7, full  # one of the two is clipped: so is their sum
    picture = mosaic(order, red, green, blue)
    decoded = decode(ORDERS[order][bits], picture.astype('u1' if bits == 8 else '<u2'), 8, 6)
    places = [divmod(place, 2) for place, colour in enumerate(order) if colour == 'G']
    total = np.sum([green[y::2, x::2].astype(int) for y, x in places], axis=0)
    saturation = PIXEL_FORMATS[ORDERS[order][bits]].saturation
    expected = total // 2 if bits == 16 else total
    expected[1, 2] = saturation
    np.testing.assert_array_equal(decoded, expected)
    assert saturation == (65535 if bits == 16 else 2 * full)


@pytest.mark.parametrize('order', PACKED)
@pytest.mark.parametrize('kind', [0, 1, 2])
def test_packed_samples(order, kind):
    name, grey = PACKED[order][kind], ('Y10P', 'Y12P', 'Y14P')[kind]
    data = np.random.default_rng(5).bytes(7 * 4 * 6)
    samples = PIXEL_FORMATS[grey].luma(data, 8, 6, 0)
    whole = ORDERS[order][10 + 2 * kind]
    expected = PIXEL_FORMATS[whole].luma(samples.astype('<u2').tobytes(), 8, 6, 0)
    np.testing.assert_array_equal(PIXEL_FORMATS[name].luma(data, 8, 6, 0), expected)


@pytest.mark.parametrize(('width', 'height'), [(7, 6), (8, 5)])
def test_half_a_cell_is_left_out(width, height):
    data = bytes(range(width * height))
    assert PIXEL_FORMATS['RGGB'].luma(data, width, height, 0).shape == (height // 2, width // 2)


@pytest.mark.parametrize(('width', 'height'), [(1, 6), (8, 1)])
def test_less_than_a_cell_is_refused(width, height):
    with pytest.raises(ValueError, match='have no cell of 2 x 2'):
        PIXEL_FORMATS['RGGB'].luma(bytes(100), width, height, 0)


@pytest.mark.parametrize('order', ORDERS)
@pytest.mark.parametrize(('red', 'blue'), [(0.0, 0.0), (2.0, 0.1), (1.0, 1.0)])
def test_a_light_of_any_colour_is_where_it_is(order, red, blue):
    # 400 pictures of a blob, Poisson and read noise: neither bias nor false covariance.
    random = np.random.default_rng(6)
    noise = SensorNoise(gain=2.0, read_noise=1.5)
    size, sigma, count = 28, 2.4, 400
    binned = SensorNoise(gain=2.0, read_noise=float(np.sqrt(2 * 1.5**2 + 1 / 12)))
    errors, squares = [], []
    for _ in range(count):
        place = size / 2 - 0.5 + random.uniform(-1, 1, 2)
        green = 250.0 * pixel_integrated_gaussian((size, size), place[0], place[1], sigma)
        mean = mosaic(order, red * green, green, blue * green) + 20.0
        raw = expose(mean, noise, random, saturation=1023)
        image = PIXEL_FORMATS[ORDERS[order][10]].luma(raw.astype('<u2').tobytes(), size, size, 0)
        found = locate(
            Window(image, saturation=2046, binning=(2, 2)), method='maximum_likelihood',
            noise=binned)
        error = np.array([found.x, found.y]) - place
        errors.append(error)
        squares.append(error @ np.linalg.solve(found.covariance, error))
    offsets = np.array(errors)
    # Four standard deviations of the mean.
    assert np.all(np.abs(offsets.mean(axis=0)) < 4 * offsets.std(axis=0) / np.sqrt(count))
    low, high = chi2.ppf([0.001, 0.999], 2 * count) / count
    assert low < np.mean(squares) < high
