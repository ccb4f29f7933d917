"""The lines of an interlaced picture go to the right field, place and time."""

from __future__ import annotations

from blob_tracker.capture.fields import (
    fields, FieldStream, MOST_ALONE, order_of, ORDERS, Weaver, woven,
)
from blob_tracker.types import Frame
import numpy as np
import pytest

HEIGHT, WIDTH, INTERVAL_NS = 8, 5, 40_000_000


def picture(order: str) -> tuple[Frame, np.ndarray]:
    """Return a picture in an order, and the lines of the whole, which hold their numbers."""
    whole = np.repeat(np.arange(HEIGHT, dtype=np.uint8)[:, None], WIDTH, axis=1)
    kinds, woven = ORDERS[order]
    image = whole if woven else np.concatenate([whole[kind::2] for kind in kinds])
    return Frame(
        image, 7, 255, x0=4, y0=10, exposure_ns=3, line_time_ns=64_000.0
    ), whole


@pytest.mark.parametrize('order', ORDERS)
def test_each_line_goes_to_its_field(order: str) -> None:
    """In the order of time, half a picture apart, without the last line of each."""
    frame, whole = picture(order)
    found = fields(frame, order, INTERVAL_NS)
    assert len(found) == len(ORDERS[order][0])
    for place, (each, kind) in enumerate(zip(found, ORDERS[order][0])):
        np.testing.assert_array_equal(each.image, whole[kind::2][:(HEIGHT - 1) // 2])
        assert each.image.flags.c_contiguous
        assert each.stamp_ns == 7 + place * INTERVAL_NS // 2
        assert (each.x0, each.y0, each.binning) == (4, 10 + kind, (1, 2))
        assert (each.exposure_ns, each.line_time_ns) == (3, 64_000.0)
        # It lies within the picture, as the roi of a camera_info has to.
        assert each.y0 + 2 * each.image.shape[0] <= frame.y0 + HEIGHT


def test_the_order_is_that_of_the_video_standard() -> None:
    """And a name that there is not is told."""
    assert (order_of('interlaced', 480), order_of('interlaced', 576)) == (
        'interlaced_bt', 'interlaced_tb'
    )
    # Which is known of a grabber, whatever the size that it scales to.
    assert [order_of('interlaced', 240, lines) for lines in (525, 625)] == [
        'interlaced_bt', 'interlaced_tb'
    ]
    with pytest.raises(ValueError, match='there is interlaced, interlaced_tb'):
        order_of('woven', 480)


def test_what_has_no_fields_is_refused() -> None:
    """A mosaic, whose neighbouring lines are of different colours, and a few lines."""
    frame, _ = picture('interlaced_tb')
    with pytest.raises(ValueError, match='Bayer'):
        fields(Frame(frame.image, 7, 255, layout='rggb'), 'interlaced', INTERVAL_NS)
    with pytest.raises(ValueError, match='3 lines'):
        fields(Frame(frame.image[:3], 7, 255), 'interlaced', INTERVAL_NS)


def test_the_planes_of_colours_are_dealt_out_too() -> None:
    """Line by line, as grey ones."""
    colours = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    top, bottom = fields(Frame(colours, 7, 255, layout='bgr'), 'interlaced_tb', INTERVAL_NS)
    assert (top.image.shape, bottom.image.shape) == ((3, WIDTH, 3), (3, WIDTH, 3))


@pytest.mark.parametrize(('name', 'per_buffer', 'per_picture', 'lines_per_line', 'words'), [
    ('none', 1, 1, 1, 'none, whole pictures'),
    ('interlaced', 2, 2, 1, 'bottom before top, line by line'),
    ('seq_tb', 2, 2, 1, 'top before bottom, one above the other'),
    ('bottom', 1, 1, 2, 'bottom alone'),
    ('alternate', 1, 2, 2, 'one after the other'),
])
def test_what_a_buffer_is_of_a_picture(
    name: str, per_buffer: int, per_picture: int, lines_per_line: int, words: str
) -> None:
    """How many frames it holds, and how many a picture has."""
    found = FieldStream(name, 480)
    assert found.interlaced == (name != 'none')
    assert (found.per_buffer, found.per_picture, found.lines_per_line) == (
        per_buffer, per_picture, lines_per_line
    )
    assert str(found) == words


@pytest.mark.parametrize('height', [8, 9])
def test_woven_fields_are_the_picture(height: int) -> None:
    """But for the last line of each field, which is the one above it."""
    image = np.arange(5 * height, dtype=np.uint8).reshape(height, 5)
    top, bottom = (each.image for each in fields(Frame(image, 0, 255), 'interlaced_tb', 2))
    again = woven(top, bottom, height)
    lines = 2 * len(top)
    np.testing.assert_array_equal(again[:lines], image[:lines])
    np.testing.assert_array_equal(again[lines:], image[lines - 2:height - 2])


def test_a_weaver_waits_for_the_other_field() -> None:
    """Whatever is lost; and not for ever, as of a camera that sums lines."""
    top, bottom = np.zeros((3, 5), np.uint8), np.ones((3, 5), np.uint8)
    weaver = Weaver()
    assert weaver.add(top, None, 8) is top
    assert [weaver.add(each, kind, 8) is None for each, kind in (
        (bottom, 1), (bottom, 1), (top, 0), (top, 0), (bottom, 1),
    )] == [True, True, False, True, False]
    assert weaver.add(top, 0, 100) is None
    picture = weaver.add(bottom, 1, 100)  # of a crop
    assert picture is not None and picture.shape == (6, 5) and (picture[1::2] == 1).all()
    for _ in range(MOST_ALONE):
        assert weaver.add(top, 0, 8) is None
    assert weaver.add(top, 0, 8) is top
