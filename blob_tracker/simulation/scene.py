"""A scene put together from a wall, a camera, a target and whatever else is in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import nan, sqrt

from blob_tracker.simulation.camera_motion import CameraMotion
from blob_tracker.simulation.noise_bank import NoiseBank
from blob_tracker.simulation.sensor import Sensor
from blob_tracker.simulation.shot import Element, Shot
from blob_tracker.simulation.spot import LightSource, truth_of
from blob_tracker.simulation.truth import Truth
from blob_tracker.simulation.wall import textured_wall
from blob_tracker.types import Pixels
import cv2
import numpy as np
from numpy.typing import NDArray

STILL = np.eye(2, 3)
MARGIN_PX = 80  # px of wall on each side of the picture, into which the camera may move
PITCH = 2  # elements of the wall to a pixel: between them cubic interpolation leaves no trace


@dataclass(frozen=True)
class Scene:
    """
    Scene and camera together: gives the frame of any index, the same bits for the same seed.

    Parameters
    ----------
    target : LightSource or None
        The light that `truth` tells of: a `Light`, or a `SpatialLight`.
    elements : sequence of Element
        What else is there, in the order in which it is drawn: lights, things that pass, glints,
        hot pixels, the sun, and light on what was drawn before. The target comes last.
    camera : CameraMotion or None
        How the camera moves; None if it stands still.
    width, height : int
        Size of the frames, px.
    rate : float
        Frames a second.
    exposure : float
        Length of the exposure, as a part of the time between frames.
    background, texture : float
        Mean of the wall and standard deviation of its pattern, DN.
    sensor : Sensor
        What turns the light into numbers.
    streaks : bool
        Whether a light that moves leaves its streak; else it stands still within an exposure.
    seed : int
        Of texture and noise.

    Raises
    ------
    ValueError
        If the rows of a rolling shutter take longer than a frame.

    Examples
    --------
    A wall, a light that is never off, and a hot pixel:

    >>> from blob_tracker.simulation import HotPixels, Light
    >>> scene = Scene(Light(40.2, 30.7, 1.5, 120.0), [HotPixels(constant=1)], width=80, height=60)
    >>> scene.frame(3).shape, scene.stamp_ns(3)  # -, ns
    ((60, 80), 1050000000)
    >>> scene.truth(3).x, scene.truth(3).lit  # px
    (40.2, True)

    """

    target: LightSource | None = None
    elements: Sequence[Element] = ()
    camera: CameraMotion | None = None
    width: int = 640
    height: int = 480
    rate: float = 60.0
    exposure: float = 0.5
    background: float = 40.0
    texture: float = 8.0
    sensor: Sensor = Sensor()
    streaks: bool = False
    seed: int = 1

    def __post_init__(self) -> None:
        read_out = self.sensor.row_time * self.height
        if read_out * self.rate > 1.0:
            raise ValueError(
                f'{self.height} rows of {self.sensor.row_time:g} s take {read_out:g} s, longer '
                f'than a frame, {1.0 / self.rate:g} s'
            )

    def stamp_ns(self, index: int) -> int:
        """Return the middle of the exposure of a frame's first row, ns."""
        return 10**9 + round(1e9 * index / self.rate) - self.before_middle_ns

    @property
    def before_middle_ns(self) -> int:
        """From the exposure of the first row to that of the middle one, ns."""
        return round(0.5e9 * self.sensor.row_time * (self.height - 1))

    def shot(self, index: int) -> Shot:
        """Return when a frame is taken and where from."""
        motion = STILL
        if self.camera is not None:
            motion = self.camera.motion(index, (self.height, self.width))
        interval = 1.0 / self.rate
        return Shot(
            index,
            index * interval,
            interval,
            self.exposure * interval,
            motion,
            self.sensor.row_time,
            0.5 * (self.height - 1),
            sqrt(self.sensor.fill_factor),
            self.streaks,
        )

    def truth(self, index: int) -> Truth:
        """Return where the target is in the picture, px, and whether it is on: half or more."""
        if self.target is None:
            return Truth(nan, nan, False)
        return truth_of(self.target, self.shot(index))

    def frame(self, index: int) -> Pixels:
        """Return the (h, w) pixels of a frame, DN."""
        return self.sensor.expose(self.mean(index), NoiseBank(self.seed, index))

    def mean(self, index: int) -> NDArray[np.float32]:
        """Return the (h, w) mean signal of a frame before its sensor, DN."""
        shot = self.shot(index)
        picture = self._seen(shot)
        for element in self.elements:
            element.draw(picture, shot)
        if self.target is not None:
            self.target.draw(picture, shot)
        return picture

    @property
    def wall(self) -> NDArray[np.float32]:
        """(h, w) mean signal of the wall that a camera at rest sees, DN; it is read-only."""
        return _wall_at_rest(
            self.width, self.height, self.background, self.texture, self.seed
        )

    def _seen(self, shot: Shot) -> NDArray[np.float32]:
        """Return the (h, w) wall as the camera sees it, DN."""
        if self.camera is None:
            return self.wall.copy()
        wall = _wall(self.width, self.height, self.background, self.texture, self.seed)
        # From elements of the wall to pixels of the scene to those of the picture.
        motion = shot.motion.copy()
        motion[:, 2] -= motion[:, :2] @ (MARGIN_PX, MARGIN_PX)
        motion[:, :2] /= PITCH
        size = (self.width, self.height)
        return np.asarray(cv2.warpAffine(
            wall, motion, size, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT_101
        ))


@lru_cache(maxsize=2)  # of scenes that differ in all but the wall it is drawn once
def _wall(
    width: int, height: int, background: float, texture: float, seed: int
) -> NDArray[np.float32]:
    """Return the mean signal of a wall, DN, at PITCH elements a pixel and with a margin."""
    shape = (PITCH * (height + 2 * MARGIN_PX), PITCH * (width + 2 * MARGIN_PX))
    wall = textured_wall(
        shape, background=background, texture=texture, seed=seed, pitch=PITCH
    )
    wall.flags.writeable = False
    return wall


@lru_cache(maxsize=2)
def _wall_at_rest(
    width: int, height: int, background: float, texture: float, seed: int
) -> NDArray[np.float32]:
    """Return the elements of the wall that are the pixels of a camera at rest."""
    inside = slice(PITCH * MARGIN_PX, -PITCH * MARGIN_PX, PITCH)
    wall = _wall(width, height, background, texture, seed)[inside, inside].copy()
    wall.flags.writeable = False
    return wall
