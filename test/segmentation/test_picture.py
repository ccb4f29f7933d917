"""The picture of the detections: what must be seen in it, and that nothing odd breaks it."""

from __future__ import annotations

from math import inf, nan

from blob_tracker.drawing import FOUND, GAP_PX, PAPER, REJECTED
from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.detections import Detections
from blob_tracker.segmentation.picture import draw, REGION, WINDOW
from blob_tracker.simulation import expose, pixel_integrated_gaussian
from blob_tracker.types import SensorNoise
from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

NOISE = SensorNoise(gain=40.0, read_noise=0.7)
TITLE = 19  # px of the line above a panel


def candidate(**changes):
    """Return something that may be the target at (100, 60)."""
    fields = dict.fromkeys(Candidate._fields, 0.0)
    fields |= {'x': 100.0, 'y': 60.0, 'sigma_major': 2.0, 'sigma_minor': 1.9, 'snr': 80.0}
    none = {'rejected': '', 'glimpse': None, 'unlit': None}
    return Candidate(**{**fields, 'height': 100.0, **none, **changes})


def detections(width=640, height=480, saturation=255, **changes):
    """Return the detections of a light at (100, 60), or the middle of what is smaller."""
    random = np.random.default_rng(1)
    x, y = min(100, width // 2), min(60, height // 2)
    wall = np.full((height, width), 0.1 * saturation)
    light = 0.4 * saturation * pixel_integrated_gaussian(wall.shape, x, y, 2.0)
    fields = {
        'lit': expose(wall + light, NOISE, random, saturation=saturation),
        'unlit': expose(wall, NOISE, random, saturation=saturation),
        'background': 0.0,
        'noise': 1.5,
        'region': Box(0, 0, width, height),
        'candidates': (candidate(x=x, y=y),),
        'windows': {'': Box(x - 6, y - 6, x + 7, y + 7)},
        'state': 'locked',
        'reason': '',
    }
    return Detections(**{**fields, **changes})


def has(picture, colour):
    """Tell whether a pixel has this colour, but for the smoothing of lines."""
    return bool((np.abs(picture.astype(int) - colour).max(axis=-1) < 30).any())


@pytest.mark.parametrize('saturation', [255, 4095])
@pytest.mark.parametrize(('width', 'height', 'shown'), [
    (160, 120, 480), (320, 240, 640), (640, 480, 640), (1280, 1024, 800), (1920, 1200, 800),
    (100, 700, 480), (2000, 20, 800),
])
def test_the_text_has_room_whatever_the_frame(width, height, shown, saturation):
    """Two panels of 480 to 800 px: small frames grow by whole numbers, large ones shrink."""
    picture = draw(detections(width, height, saturation))
    assert picture.dtype == np.uint8
    assert picture.shape[1:] == (2 * shown + 3 * GAP_PX, 3)
    assert has(picture, WINDOW)


@pytest.mark.parametrize(('width', 'height', 'scale'), [(160, 120, 3), (640, 480, 1)])
def test_the_difference_is_signed_and_in_its_place(width, height, scale):
    """What rose is white, what fell black, the rest grey about the middle."""
    one = detections(width, height, windows={}, candidates=())
    unlit = one.unlit.copy()
    unlit[20, 30] = 200
    picture = draw(one._replace(unlit=unlit))
    left = picture.shape[1] - GAP_PX - scale * width
    panel = picture[TITLE:TITLE + scale * height, left:left + scale * width]
    x, y = min(100, width // 2), min(60, height // 2)
    assert panel[scale * y, scale * x].min() == 255
    assert panel[scale * 20, scale * 30].max() == 0
    # An eighth of the noise is 16 levels: the mean of all pixels is within one of the middle.
    assert abs(float(np.median(panel)) - 127.5) < 2.0


def test_a_window_is_drawn_about_its_pixels():
    """Its outline runs through its outermost pixels, in frame and difference."""
    picture = draw(detections(candidates=()))
    for left in (GAP_PX, picture.shape[1] - GAP_PX - 640):
        rows, columns = np.nonzero(
            (picture[TITLE:TITLE + 480, left:left + 640] == WINDOW).all(axis=-1)
        )
        assert (columns.min(), columns.max(), rows.min(), rows.max()) == (94, 106, 54, 66)


def test_candidates_and_region_have_colours_of_their_own():
    """Green for what may be the target, orange for what was rejected, blue for the region."""
    one = detections(windows={}, candidates=(), reason='nothing lit up')
    # The line of text that says the reason is orange as well: panels only.
    plain = draw(one)[TITLE:TITLE + 480]
    assert not any(has(plain, colour) for colour in (FOUND, REJECTED, REGION))
    picture = draw(one._replace(
        candidates=(candidate(), candidate(x=300.0, rejected='a lone pixel')),
        region=Box(50, 40, 400, 300),
    ))[TITLE:TITLE + 480]
    assert all(has(picture, colour) for colour in (FOUND, REJECTED, REGION))


def test_long_text_stays_inside():
    """Sentences are wrapped, and candidates that find no line are counted."""
    many = tuple(
        candidate(x=7.0 * index, rejected='a rise that is none, and that at length ' * 4)
        for index in range(90)
    )
    picture = draw(detections(candidates=many, reason='why it is no target ' * 30, windows={}))
    assert (picture[:, -GAP_PX:] == PAPER).all()
    assert (picture[-GAP_PX:] == PAPER).all()
    assert picture.shape[0] < 1000


numbers = st.floats(allow_nan=True, allow_infinity=True)
candidates = st.builds(
    candidate,
    **dict.fromkeys(['x', 'y', 'sigma_major', 'sigma_minor', 'snr', 'height'], numbers),
    rejected=st.sampled_from(['', 'no', 'ein schräger\nGrund ' * 9]),
)
whole = st.integers(-3000, 3000)


@settings(max_examples=40, deadline=None, derandomize=True, database=None)
@given(
    size=st.tuples(st.integers(1, 200), st.integers(1, 200)),
    kind=st.sampled_from([np.uint8, np.uint16, np.float32]),
    unlit=st.sampled_from(['none', 'same', 'other']),
    level=st.sampled_from([0, 17, 255, 65535]),
    background=numbers,
    noise=numbers,
    region=st.builds(Box, whole, whole, whole, whole),
    found=st.lists(candidates, max_size=12),
    boxes=st.lists(st.builds(Box, whole, whole, whole, whole), max_size=5),
)
def test_nothing_odd_breaks_it(
    size, kind, unlit, level, background, noise, region, found, boxes
):
    """Any numbers at all: a picture comes of them."""
    lit = np.full(size, min(level, np.iinfo(kind).max) if kind is not np.float32 else nan, kind)
    dark = {'none': None, 'same': lit, 'other': np.zeros((3, 5), kind)}[unlit]
    picture = draw(Detections(
        lit, dark, background, noise, region, tuple(found),
        {f'light{index}': box for index, box in enumerate(boxes)}, 'lost', '',
    ))
    assert picture.dtype == np.uint8
    assert picture.shape[1] >= 984


@pytest.mark.parametrize('noise', [0.0, nan, inf, -1.0])
def test_a_target_at_the_edge(noise):
    """A window that the frame cuts, and a noise that is none."""
    picture = draw(detections(
        noise=noise,
        windows={'': Box(-4, -5, 9, 8)},
        candidates=(candidate(x=-0.4, y=-0.3),),
    ))
    assert has(picture[TITLE:TITLE + 480], WINDOW)
