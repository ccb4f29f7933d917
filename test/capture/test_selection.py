"""Crops that the driver in test/vm cannot be brought to have."""

from __future__ import annotations

import errno
from typing import Any

from blob_tracker.capture import CaptureError, videodev2
from blob_tracker.capture.selection import sensor_region, SensorRegion
import pytest

CROP, DEFAULT, COMPOSE = (
    videodev2.SEL_TGT_CROP, videodev2.SEL_TGT_CROP_DEFAULT, videodev2.SEL_TGT_COMPOSE)


def driver(**rectangles):
    """Return the ioctl of a driver that knows these rectangles and cannot change them."""
    known = {'crop': CROP, 'default': DEFAULT, 'compose': COMPOSE}
    targets = {known[name]: value for name, value in rectangles.items()}

    def ioctl(number: int, selection: Any) -> None:
        assert selection.type == videodev2.BUF_TYPE_VIDEO_CAPTURE
        if not targets:
            raise OSError(errno.ENOTTY, 'Inappropriate ioctl for device')
        if selection.target not in targets or number != videodev2.G_SELECTION:
            raise OSError(errno.EINVAL, 'Invalid argument')
        selection.r = videodev2.Rect(*targets[selection.target])
    return ioctl


@pytest.mark.parametrize('rectangles', [
    {},
    # as uvcvideo has it: no crop, and what the camera gives is all there is
    {'default': (0, 0, 640, 480)},
])
def test_without_a_crop_the_frame_is_the_sensor(rectangles):
    region = sensor_region(driver(**rectangles), '/dev/video0', 640, 480)
    assert region == SensorRegion(0, 0, (1, 1), (640, 480))


def test_the_place_counts_from_the_default_rectangle():
    # A sensor with 8 dark columns and 16 dark rows in front of its picture.
    region = sensor_region(
        driver(crop=(108, 66, 640, 480), default=(8, 16, 1920, 1080)), '/dev/video0', 320, 480)
    assert region == SensorRegion(100, 50, (2, 1), (1920, 1080))


@pytest.mark.parametrize(('rectangles', 'binning'), [
    ({}, (1, 1)),
    ({'crop': (0, 0, 720, 576), 'default': (0, 0, 720, 576), 'compose': (0, 0, 720, 288)}, (1, 1)),
    ({'crop': (0, 0, 720, 576), 'default': (0, 0, 720, 576), 'compose': (0, 0, 360, 144)}, (2, 2)),
])
def test_a_field_is_half_of_the_lines_and_no_binning(rectangles, binning):
    # Crops are in lines of the picture, what the driver fills in those of the field.
    size = (720 // binning[0], 288 // binning[1])
    region = sensor_region(driver(**rectangles), '/dev/video0', *size, lines_per_line=2)
    assert region == SensorRegion(0, 0, binning, (720, 576))


@pytest.mark.parametrize('crop', [(0, 16, 640, 480), (8, 15, 640, 480), (1608, 16, 640, 480)])
def test_a_crop_beyond_the_sensor_is_refused(crop):
    with pytest.raises(CaptureError, match='reaches beyond the sensor of 1920x1080 at'):
        sensor_region(driver(crop=crop, default=(8, 16, 1920, 1080)), '/dev/video0', 640, 480)


@pytest.mark.parametrize('width', [1280, 400])
def test_a_crop_that_is_enlarged_or_scaled_by_no_whole_number_is_refused(width):
    with pytest.raises(CaptureError, match=f'of 640x480 is scaled to frames of {width}x480'):
        sensor_region(
            driver(crop=(0, 0, 640, 480), default=(0, 0, 1920, 1080)), '/dev/video0', width, 480)


def test_a_frame_that_stays_partly_empty_is_refused():
    rectangles = {name: (0, 0, 320, 240) for name in ('crop', 'default', 'compose')}
    with pytest.raises(CaptureError, match=r'fills 320x240 at \(0, 0\) of frames of 640x480'):
        sensor_region(driver(**rectangles), '/dev/video0', 640, 480)
