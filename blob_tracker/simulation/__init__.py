"""The virtual lab: light, optics and sensor, with the truth kept."""

from blob_tracker.simulation.flashing_light import FlashingLight, Truth
from blob_tracker.simulation.light import pixel_integrated_gaussian
from blob_tracker.simulation.sensor import expose

__all__ = ['FlashingLight', 'Truth', 'expose', 'pixel_integrated_gaussian']
