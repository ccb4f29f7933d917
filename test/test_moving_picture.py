"""The moving picture of the README is what tools/moving_picture.py draws."""

from __future__ import annotations

from pathlib import Path

from blob_tracker import CameraModel, Frame
from blob_tracker.camera import pinhole_matrix
from blob_tracker.location import locate
from blob_tracker.segmentation import Segmenter
import moving_picture
from moving_picture import COUNT, HEIGHT, INTERVAL, NOISE, WIDTH
from PIL import Image

OUT = Path(__file__).parents[1] / 'docs' / 'demo.gif'


def test_the_file() -> None:
    """Every other pair of one way round, at the pace that is said, and small."""
    with Image.open(OUT) as picture:
        assert picture.n_frames == COUNT // 2
        assert picture.info['duration'] == INTERVAL
    assert OUT.stat().st_size < 1_500_000


def test_a_picture_of_a_light_that_was_found() -> None:
    """Frame and window beside each other."""
    scene = moving_picture.scene()
    segmenter = Segmenter()
    window = None
    for index in range(7):
        frame = Frame(scene.frame(index), stamp_ns=scene.stamp_ns(index), saturation=255)
        window = segmenter.update(frame) or window
    assert window is not None
    location = locate(window, noise=NOISE)
    bearing = CameraModel(WIDTH, HEIGHT, pinhole_matrix(400.0, WIDTH, HEIGHT)).bearing(location)
    path = [(location.x, location.y)]
    drawn = moving_picture.picture(frame.image, window, bearing, path, lit=True)
    assert drawn.shape[0] == HEIGHT and drawn.shape[1] > WIDTH
