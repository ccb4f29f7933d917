"""The virtual lab: light, optics and sensor, with the truth kept."""

from blob_tracker.simulation.ambient_light import AmbientLight
from blob_tracker.simulation.blinking_lights import blinking_lights, waveforms_of
from blob_tracker.simulation.camera_motion import Drifting, Stepping
from blob_tracker.simulation.flashing_light import flashing_light
from blob_tracker.simulation.flat_field import FlatField
from blob_tracker.simulation.glints import Glints
from blob_tracker.simulation.hot_pixels import HotPixels
from blob_tracker.simulation.interlaced import InterlacedCamera
from blob_tracker.simulation.light import pixel_integrated_gaussian
from blob_tracker.simulation.optics import Optics, SpatialLight
from blob_tracker.simulation.passing_object import PassingObject
from blob_tracker.simulation.point_light import Light
from blob_tracker.simulation.profiles import (
    Comatic, Gaussian, Measured, PROFILES, ThreeGaussians,
)
from blob_tracker.simulation.quantisation import gain_plus_uniform
from blob_tracker.simulation.scene import Scene
from blob_tracker.simulation.sensor import expose, Sensor, Stage
from blob_tracker.simulation.spot import add_spot, Spot, truth_of
from blob_tracker.simulation.sun_disc import SunDisc
from blob_tracker.simulation.truth import Truth
from blob_tracker.simulation.waveforms import always, coded, in_step, periodic, sinusoid

__all__ = [
    'AmbientLight',
    'Comatic',
    'Drifting',
    'FlatField',
    'Gaussian',
    'Glints',
    'HotPixels',
    'InterlacedCamera',
    'Light',
    'Measured',
    'Optics',
    'PROFILES',
    'PassingObject',
    'Scene',
    'Sensor',
    'SpatialLight',
    'Spot',
    'Stage',
    'Stepping',
    'SunDisc',
    'ThreeGaussians',
    'Truth',
    'add_spot',
    'always',
    'blinking_lights',
    'coded',
    'expose',
    'flashing_light',
    'gain_plus_uniform',
    'in_step',
    'periodic',
    'pixel_integrated_gaussian',
    'sinusoid',
    'truth_of',
    'waveforms_of',
]
