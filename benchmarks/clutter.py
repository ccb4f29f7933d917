"""Scenes in which a flashing light is hard to find, with the truth of every frame."""

from __future__ import annotations

from dataclasses import dataclass, replace

from blob_tracker.simulation import (
    AmbientLight, Drifting, Glints, HotPixels, in_step, Light, PassingObject, periodic, Scene,
    Sensor, sinusoid, SunDisc,
)
import numpy as np

WIDTH, HEIGHT = 320, 240
RATE = 60.0  # frames a second: lamps of 100 Hz are seen at 20 Hz, those of 120 Hz at 0
IN_STEP_RATE = 40.0  # at which those of 100 Hz are brighter in every other frame
EXPOSURE = 0.3  # of the time between frames
# The target goes about in the upper left. What stands in the scene stands elsewhere, 30 px and
# more from its path, so that the truth of a frame is never hidden behind something.
TARGET_X, TARGET_Y = 110.0, 75.0
REACH_X, REACH_Y = 55.0, 30.0
SLOW = Drifting(speed=3.0, radius=25.0, shake=1.0, turn=0.5)

LAMPS = (
    Light(250.0, 40.0, 1.5, 60.0, sinusoid(100.0, 0.1)),
    Light(285.0, 70.0, 2.5, 80.0, sinusoid(100.0, 0.4, 0.2)),
    Light(250.0, 100.0, 1.2, 50.0, sinusoid(100.0, 1.0, 0.4)),
    Light(290.0, 130.0, 4.0, 100.0, sinusoid(100.1, 0.7, 0.1)),
    Light(60.0, 190.0, 2.0, 70.0, sinusoid(120.0, 1.0, 0.3)),
    Light(110.0, 200.0, 1.5, 90.0, sinusoid(120.3, 1.0)),
    Light(160.0, 185.0, 3.0, 60.0, sinusoid(119.0, 0.5)),
    Light(210.0, 200.0, 1.0, 120.0, sinusoid(100.0, 0.5, 0.7)),
)
OTHERS = (
    Light(250.0, 50.0, 2.0, 120.0),
    Light(270.0, 100.0, 4.0, 80.0),
    Light(60.0, 190.0, 1.0, 150.0),
    Light(200.0, 190.0, 2.0, 100.0, reach_x=60.0, reach_y=15.0, period=6.0),  # goes about
    Light(285.0, 140.0, 1.5, 100.0, periodic(1.5, 0.5)),  # an indicator
)
PASSING = (
    PassingObject(0.0, 190.0, 60.0, 36.0, 110.0, speed_x=4.0),
    PassingObject(268.0, 0.0, 30.0, 50.0, 8.0, speed_x=0.0, speed_y=-2.5),
    PassingObject(150.0, 155.0, 5.0, 4.0, 140.0, speed_x=-6.3),
    PassingObject(20.0, 222.0, 14.0, 8.0, 75.0, speed_x=0.6),
)
GLINTS = Glints(rate=0.5, region=(0.0, 0.68, 1.0, 1.0), seed=4)
HOT = (
    HotPixels(constant=25, blinking=15, region=(0.0, 0.64, 1.0, 1.0), seed=5),
    HotPixels(constant=25, blinking=15, region=(0.7, 0.0, 1.0, 0.64), seed=6),
    HotPixels(constant=30, blinking=0, seed=7),
)
SUN = SunDisc(262.0, 65.0, radius=10.0)
# None of these is brighter than 1: the target's SNR is never below the one that is named. A pair
# across a step or a band differs by its texture too, times the change.
BANDS = AmbientLight(lambda times: sinusoid(100.0, 0.15)(times) / 1.15)
ROLLING = Sensor(row_time=0.9 / (RATE * HEIGHT))  # all but the whole of the time of a frame
CLOUDS = AmbientLight(lambda times: sinusoid(0.7, 0.3)(times) / 1.3)
SWITCHED = AmbientLight(lambda times: 1.0 - 0.1 * periodic(2.3, 0.5)(times))


@dataclass(frozen=True)
class Clutter:
    """
    A scene without its target.

    Parameters
    ----------
    scene : Scene
        What there is.
    registration : str
        How the segmenter is told to lay the frames of a pair over each other.

    """

    scene: Scene
    registration: str = 'none'


def clutter() -> dict[str, Clutter]:
    """Return the scenes by name."""
    wall = Scene(width=WIDTH, height=HEIGHT, rate=RATE, exposure=EXPOSURE)
    every = (*PASSING[:1], *LAMPS[:4], GLINTS, SUN, CLOUDS, HOT[0])
    return {
        'plain': Clutter(replace(wall, texture=0.0)),
        'textured wall': Clutter(wall),
        'drifting camera': Clutter(replace(wall, camera=SLOW), 'affine'),
        'mains lamps': Clutter(replace(wall, elements=LAMPS)),
        'lamps in step': Clutter(replace(wall, elements=LAMPS, rate=IN_STEP_RATE)),
        'other lights': Clutter(replace(wall, elements=OTHERS)),
        'passing objects': Clutter(replace(wall, elements=PASSING)),
        'glints': Clutter(replace(wall, elements=(GLINTS,))),
        'hot pixels': Clutter(replace(wall, elements=HOT)),
        'rolling shutter': Clutter(replace(wall, elements=(BANDS,), sensor=ROLLING)),
        'changing light': Clutter(replace(wall, elements=(CLOUDS, SWITCHED))),
        'sun': Clutter(replace(wall, elements=(SUN,), camera=SLOW), 'affine'),
        'everything': Clutter(replace(wall, elements=every, camera=SLOW), 'affine'),
    }


def amplitude(scene: Scene, snr: float) -> float:
    """Return the DN at which A^2 = SNR^2 ((A + b) / gain + read_noise^2 + 1/12)."""
    square, noise = snr**2, scene.sensor.noise
    linear = square / noise.gain
    fixed = square * (scene.background / noise.gain + noise.read_noise**2 + 1 / 12)
    return linear / 2 + float(np.sqrt(linear**2 / 4 + fixed))


def with_target(scene: Scene, snr: float, sigma: float) -> Scene:
    """Return the scene with a light that flashes in step, of a peak SNR in one frame's pixel."""
    target = Light(
        TARGET_X,
        TARGET_Y,
        sigma,
        amplitude(scene, snr),
        in_step(scene.rate),
        reach_x=REACH_X,
        reach_y=REACH_Y,
    )
    return replace(scene, target=target)
