"""Bags as a source of frames."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from blob_tracker.camera.response import Response
from blob_tracker.commands.sources import grey_frames, Source, SourceError, SourceFrame
from blob_tracker.commands.sources.bag import open_bag
from blob_tracker.ros.endpoints.recording import recorded_frames
from blob_tracker.types import Frame
import cv2
import numpy as np
import pytest
from rosbags.rosbag2 import Writer
from rosbags.typesys import get_typestore, Stores

PIXELS = np.arange(6, dtype=np.uint8)


TYPES = get_typestore(Stores.ROS2_JAZZY)
NAMES = {each.rpartition('/')[2]: kind for each, kind in TYPES.types.items()}


def header(index: int, *, stamped: bool = True) -> Any:
    """Return a header, 20 ms after the one before it."""
    time = NAMES['Time'](1, 20_000_000 * index) if stamped else NAMES['Time'](0, 0)
    return NAMES['Header'](time, 'optical')


def info(index: int, size: tuple[int, int], roi: tuple[int, int, int, int], *, binning:
         tuple[int, int], stamped: bool = True) -> Any:
    """Return a camera_info; the roi is x, y, height and width."""
    return NAMES['CameraInfo'](
        header(index, stamped=stamped), size[1], size[0], 'plumb_bob', np.zeros(5), np.zeros(9),
        np.zeros(9), np.zeros(12), *binning, NAMES['RegionOfInterest'](*roi, False))


def image(index: int, *, compressed: bool = False, stamped: bool = True) -> Any:
    """Return an image of 2 x 3 px."""
    pixels = PIXELS.reshape(3, 2) + index
    if compressed:
        data = cv2.imencode('.png', pixels)[1].ravel()
        return NAMES['CompressedImage'](header(index, stamped=stamped), 'png', data)
    return NAMES['Image'](
        header(index, stamped=stamped), 3, 2, 'mono8', 0, 2, pixels.ravel())


def written(bag: Path, messages: list[tuple[str, Any]]) -> Path:
    """Write a bag of messages with their topics."""
    with Writer(bag, version=8) as writer:
        connections: dict[str, Any] = {}
        for index, (topic, message) in enumerate(messages):
            kind = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=TYPES)
            writer.write(
                connections[topic], 10**9 + 10_000_000 * index,
                TYPES.serialize_cdr(message, kind))
    return bag


@pytest.mark.parametrize('compressed', [False, True])
def test_fields_are_woven_where_it_is_asked_for(compressed: bool, tmp_path: Path) -> None:
    """By the camera_info beside the images; one that is missing leaves a field as it is."""
    topic = 'front/image_raw/compressed' if compressed else 'front/image_raw'
    bag = written(tmp_path / 'fields', [
        each for index in range(5) for each in (
            ('front/camera_info', info(index, (2, 8), (0, index % 2, 6, 2), binning=(1, 2))),
            (topic, image(index, compressed=compressed)),
        )
    ])
    woven = open_bag(bag, topic, calibrated=False, woven=True)
    assert [each.frame.binning for each in woven.frames] == [(1, 1)] * 2
    fields, pictures = (
        list(grey_frames(open_bag(bag, topic, calibrated=False, woven=woven)))
        for woven in (False, True)
    )
    assert len(fields) == 5
    assert [seconds for _, seconds, _, _ in pictures] == pytest.approx([0.0, 0.04])
    assert pictures[0][2].tolist() == [
        [0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 6], [4, 5], [5, 6]]


@pytest.mark.parametrize('compressed', [False, True])
def test_crop_and_binning_are_those_of_the_camera_info(compressed: bool, tmp_path: Path) -> None:
    """A response of the sensor is accepted by its crops, and one of another sensor is not."""
    topic = 'front/image_raw/compressed' if compressed else 'front/image_raw'
    bag = written(tmp_path / 'crop', [
        ('front/camera_info', info(0, (64, 48), (8, 4, 6, 4), binning=(2, 2))),
        (topic, image(0, compressed=compressed)),
    ])
    for calibrated in (False, True):
        source = open_bag(bag, topic, calibrated=calibrated, woven=False)
        (name, frame, _, sensor), = source.frames
        assert (frame.x0, frame.y0, frame.binning, sensor) == (8, 4, (2, 2), (64, 48))
    levels = np.array([0.0, 100.0, 255.0])
    for width, right in ((64, True), (4, False)):
        response = Response(levels, 16.0 * levels, np.zeros(3), width, 48)
        source = open_bag(bag, topic, calibrated=False, woven=False)
        if right:
            (grey,) = grey_frames(source, response=response)
            assert grey.pixels.max() == 16 * PIXELS.max() and grey.sensor == (64, 48)
        else:
            with pytest.raises(SourceError, match='of a camera with 4 x 48 px'):
                list(grey_frames(source, response=response))


def test_each_colour_is_made_linear_before_they_are_mixed() -> None:
    """As the nodes do it: of a square law luma is the mix of squares."""
    levels = np.linspace(0.0, 255.0, 52)
    response = Response(levels, 16.0 * levels**2 / 255.0, np.zeros(52), 4, 4)
    pixels = np.full((4, 4, 3), (200, 100, 50), np.uint8)
    frame = Frame(pixels, 0, 255, layout='rgb')
    (grey,) = grey_frames(Source([SourceFrame('one', frame, False)]), response=response)
    right = 16.0 / 255.0 * (0.299 * 200**2 + 0.587 * 100**2 + 0.114 * 50**2)
    assert grey.pixels[0, 0] == pytest.approx(right, abs=1.5)  # of the roundings


def test_images_that_wait_in_vain_are_counted(tmp_path: Path) -> None:
    """However many; those without a stamp go with the camera_infos by their order."""
    images: list[tuple[str, Any]] = [('front/image_raw', image(k)) for k in range(30)]
    whole = (0, 0, 0, 0)
    for k in range(3):
        images.append(('front/image_raw', image(k, stamped=False)))
    for k in range(3):
        images.append(('front/camera_info', info(
            k, (2, 3), whole, binning=(1, 1), stamped=False)))
    told: list[str] = []
    bag = written(tmp_path / 'alone', images)
    found = list(recorded_frames(bag, paired=True, warn=told.append))
    assert [int(frame.image[0, 0]) for frame, _ in found] == [0, 1, 2]
    assert len(told) == 1 and '30 images have no camera_info of their stamp' in told[0]
