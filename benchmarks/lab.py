"""How fast the virtual lab draws: frames a second of one core."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from statistics import median
from time import process_time

from blob_tracker.simulation import Drifting, flashing_light, Scene, Sensor
from blob_tracker.types import SensorNoise

Tick = Callable[[str], None]

FRAMES = 100  # of a repeat, half of them lit
DEFAULT = 'a flashing light, 640 x 480'


@dataclass(frozen=True)
class Row:
    """
    One kind of scene.

    Parameters
    ----------
    scene : str
        Name.
    per_second : float
        Frames a second of processor time, median of the repeats; wall and noise are there, as
        they are from the second frame on.

    """

    scene: str
    per_second: float


def scenes() -> dict[str, Scene]:
    """Return the default scene, and what else may be asked of it."""
    plain = flashing_light()
    fixed = Sensor(
        SensorNoise(gain=40.0, read_noise=0.7), full_well=12_000.0, blooming=True, prnu=0.01,
        dsnu=0.3,
    )
    return {
        DEFAULT: plain,
        'the same, rolling shutter': replace(plain, sensor=Sensor(row_time=30e-6)),
        'the same, fixed pattern, full wells that bloom': flashing_light(
            amplitude=500.0, sensor=fixed
        ),
        'the same, moving camera': replace(plain, camera=Drifting(3.0)),
    }


def steps() -> int:
    """Return how many ticks `run` makes."""
    return len(scenes())


def run(repeats: int, tick: Tick) -> list[Row]:
    """Return the row of each scene."""
    rows = []
    for name, scene in scenes().items():
        tick(f'lab: {name}')
        scene.frame(0)
        rows.append(Row(name, median(_rate(scene) for _ in range(repeats))))
    return rows


def _rate(scene: Scene) -> float:
    began = process_time()
    for index in range(FRAMES):
        scene.frame(index)
    return FRAMES / (process_time() - began)
