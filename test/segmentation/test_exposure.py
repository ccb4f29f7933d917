"""Frames in which no target could be seen are told from those in which one could."""

from blob_tracker.segmentation import exposure_fault
from blob_tracker.simulation import flashing_light
from blob_tracker.types import Frame
import numpy as np
import pytest


@pytest.mark.parametrize(('level', 'saturation', 'sentence'), [
    (0, 255, 'the brightest pixel is 0 DN of 255: is the lens cap on?'),
    (3, 255, 'the brightest pixel is 3 DN of 255'),
    (60, 4095, 'the brightest pixel is 60 DN of 4095'),
    (255, 255, '100 % of the pixels are clipped at 255 DN'),
    (4095, 4095, '100 % of the pixels are clipped at 4095 DN'),
    (90, 255, 'every pixel is 90 DN: the camera gives no picture'),
])
def test_even_frames_are_named(level, saturation, sentence):
    """Dark, blown out, or no picture at all."""
    image = np.full((120, 160), level, np.uint8 if saturation < 256 else np.uint16)
    assert sentence in exposure_fault(Frame(image, 0, saturation))


def test_a_frame_that_is_mostly_clipped_is_named():
    """Two thirds of it."""
    image = np.full((120, 160), 255, np.uint8)
    image[:40] = 100
    assert '67 % of the pixels are clipped' in exposure_fault(Frame(image, 0, 255))


def test_a_scene_has_no_fault():
    """Also at night, with nothing but the light, and with a third of it in the sun."""
    scene = flashing_light(width=160, height=120)
    image = scene.frame(2)
    assert exposure_fault(Frame(image, 0, 255)) == ''
    night = np.zeros_like(image)
    night[50:53, 60:63] = 40
    assert exposure_fault(Frame(night, 0, 255)) == ''
    sunny = image.copy()
    sunny[:40] = 255
    assert exposure_fault(Frame(sunny, 0, 255)) == ''
