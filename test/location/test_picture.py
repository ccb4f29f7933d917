"""The picture of a window: what must be seen in it, and that nothing odd breaks it."""

from __future__ import annotations

from math import inf

from blob_tracker.camera import CameraModel, pinhole_matrix
from blob_tracker.drawing import CLIPPED, FOUND, GAP_PX, LINE_PX, PAPER, REJECTED
from blob_tracker.location import locate
from blob_tracker.location.picture import CENTRE, COVARIANCE, draw, PANEL_PX, WIDTH
from blob_tracker.simulation import expose, pixel_integrated_gaussian
from blob_tracker.types import Location, LocationError, SensorNoise, Window
from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

NOISE = SensorNoise(gain=40.0, read_noise=0.7)
CAMERA = CameraModel(640, 480, pinhole_matrix(600.0, 640, 480))


def window(height=13, width=13, amplitude=120.0, saturation=255, steady=False, **fields):
    """Return a window with a blob in its middle, on a dark wall."""
    random = np.random.default_rng(1)
    wall = np.full((height, width), 0.1 * saturation)
    middle = 0.5 * (width - 1), 0.5 * (height - 1)
    sigma = 0.15 * min(height, width)
    light = amplitude / 255.0 * saturation * pixel_integrated_gaussian(wall.shape, *middle, sigma)
    lit = expose(wall + light, NOISE, random, saturation=saturation)
    unlit = None if steady else expose(wall, NOISE, random, saturation=saturation)
    return Window(lit, unlit, 100, 60, 1, saturation, **fields)


def picture_of(one):
    """Return the picture of a window in which the blob is placed."""
    location = locate(one, noise=NOISE)
    return location, draw(one, NOISE, location, CAMERA.bearing(location))


def panel(picture, index):
    """Return one of the panels of a square window."""
    left = GAP_PX + index * (PANEL_PX + GAP_PX)
    return picture[GAP_PX + LINE_PX:GAP_PX + LINE_PX + PANEL_PX, left:left + PANEL_PX]


def places(picture, colour):
    """Return the rows and columns of a colour, but for the smoothing of lines."""
    return np.nonzero(np.abs(picture.astype(int) - colour).max(axis=-1) < 30)


@pytest.mark.parametrize(('steady', 'panels'), [(False, 4), (True, 3)])
@pytest.mark.parametrize('saturation', [255, 65535])
@pytest.mark.parametrize(
    ('height', 'width'), [(5, 5), (7, 15), (15, 7), (13, 13), (257, 257), (400, 300)]
)
def test_what_was_found_is_marked_whatever_the_window(height, width, saturation, steady, panels):
    """All windows fill a panel, and nothing is written over the border."""
    location, picture = picture_of(window(height, width, saturation=saturation, steady=steady))
    assert picture.dtype == np.uint8
    assert picture.shape[1] == panels * (PANEL_PX + GAP_PX) + GAP_PX
    assert (picture[:, :GAP_PX] == PAPER).all()
    assert (picture[:, -GAP_PX:] == PAPER).all()
    assert (picture[-GAP_PX:] == PAPER).all()
    for colour in (CENTRE, WIDTH, COVARIANCE, FOUND):
        assert places(picture, colour)[0].size


def test_the_marks_are_in_their_places():
    """The cross on the centre; the circle as wide as the fitted sigma says."""
    one = window()
    location, picture = picture_of(one)
    scale = PANEL_PX // 13
    found = panel(picture, 2)
    row, column = (np.mean(which) for which in places(found, CENTRE))
    # A picture pixel for rounding, and one for the middle of a line.
    assert column == pytest.approx((location.x - 100 + 0.5) * scale - 0.5, abs=2.0)
    assert row == pytest.approx((location.y - 60 + 0.5) * scale - 0.5, abs=2.0)
    rows, columns = places(found, WIDTH)
    for which in (rows, columns):
        assert np.ptp(which) / 2.0 == pytest.approx(scale * location.sigma, abs=2.0)


def test_the_marks_follow_the_binning():
    """A window of 2 x 2 sensor pixels each has its cross in the same place."""
    location, picture = picture_of(window(binning=(2, 2)))
    row, column = (np.mean(which) for which in places(panel(picture, 2), CENTRE))
    assert (row, column) == pytest.approx((13 * 22 / 2, 13 * 22 / 2), abs=3.0)


def test_the_residual_is_noise_where_the_pulse_fits():
    """Grey in the mean, and spread by its own sigma: 255 / 10 levels each."""
    one = window(25, 25)
    _, picture = picture_of(one)
    scale = PANEL_PX // 25
    residual = panel(picture, 3)[:25 * scale:scale, :25 * scale:scale, 0].astype(float)
    # The error of the mean and of the spread of 625 pixels are 4 % and 3 % of sigma; four times.
    assert residual.mean() == pytest.approx(127.5, abs=4.0)
    assert residual.std() == pytest.approx(25.5, rel=0.12)


def test_clipped_pixels_are_red():
    """In the lit window, in the difference and in the residual; not in the unlit one."""
    one = window(amplitude=600.0)
    count = np.count_nonzero(one.lit >= 255)
    _, picture = picture_of(one)
    scale = PANEL_PX // 13
    red = [places(panel(picture, index), CLIPPED)[0].size for index in range(4)]
    assert red[0] == red[3] == count * scale**2 > 0
    assert red[1] == 0
    assert 0.5 * red[0] < red[2] < red[0]  # the marks lie over it


def test_a_refusal_is_said():
    """Without marks, in the colour of what was refused."""
    picture = draw(window(), NOISE, reason='the window does not hold one blob ' * 8)
    assert picture.shape[1] == 3 * (PANEL_PX + GAP_PX) + GAP_PX
    assert places(picture, REJECTED)[0].size
    assert not places(picture, FOUND)[0].size
    assert (picture[:, -GAP_PX:] == PAPER).all()


numbers = st.floats(1e-6, 1e6)


@settings(max_examples=40, deadline=None, derandomize=True, database=None)
@given(
    size=st.tuples(st.integers(1, 60), st.integers(1, 60)),
    kind=st.sampled_from([np.uint8, np.uint16, np.float32]),
    level=st.sampled_from([0.0, 17.0, 255.0, inf]),
    steady=st.booleans(),
    where=st.tuples(st.floats(-1e7, 1e7), st.floats(-1e7, 1e7)),
    variances=st.tuples(numbers, numbers),
    correlation=st.floats(-0.999, 0.999),
    values=st.tuples(numbers, numbers, numbers, numbers, numbers),
    gain=st.sampled_from([1e-3, 40.0, inf]),
)
def test_nothing_odd_breaks_it(
    size, kind, level, steady, where, variances, correlation, values, gain
):
    """Any location that a method may return, and pixels of any kind."""
    with np.errstate(invalid='ignore'):
        lit = np.full(size, level).astype(kind)
    mixed = correlation * np.sqrt(variances[0] * variances[1])
    location = Location(
        *where, np.array([[variances[0], mixed], [mixed, variances[1]]]), *values, saturated=3
    )
    one = Window(lit, None if steady else lit, 0, 0, 0, 255)
    noise = SensorNoise(gain, 0.0)
    assert draw(one, noise, location).dtype == np.uint8
    try:
        locate(one, noise=noise)
    except LocationError as error:
        assert draw(one, noise, reason=str(error)).dtype == np.uint8
