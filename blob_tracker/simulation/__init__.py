"""The virtual lab: light, optics and sensor, with the truth kept."""

from blob_tracker.simulation.blinking_lights import BlinkingLights, coded, Light, periodic
from blob_tracker.simulation.flashing_light import FlashingLight, Truth
from blob_tracker.simulation.light import pixel_integrated_gaussian
from blob_tracker.simulation.moving_camera import MovingCamera
from blob_tracker.simulation.sensor import expose

__all__ = [
    'BlinkingLights',
    'FlashingLight',
    'Light',
    'MovingCamera',
    'Truth',
    'coded',
    'expose',
    'periodic',
    'pixel_integrated_gaussian',
]
