"""A camera on a pan/tilt on a vehicle: a light in a known direction, as this camera sees it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from math import ceil, sqrt

from blob_tracker.camera import CameraModel
from blob_tracker.simulation.analogue_chain import AnalogueChain
from blob_tracker.simulation.line_jitter import jittering_offsets
from blob_tracker.simulation.noise_bank import NoiseBank
from blob_tracker.simulation.platform_motion import Ride, turn_about
from blob_tracker.simulation.profiles import Gaussian, Profile
from blob_tracker.simulation.sensor import Sensor
from blob_tracker.simulation.trailing_edge import peaked
from blob_tracker.simulation.wall import textured_wall
from blob_tracker.simulation.waveforms import mean_over, Waveform
from blob_tracker.types import Frame
import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Turned = Callable[[Array], Array]
ROUNDS = 4  # each brings the time of the light's row nearer by its speed over the shutter's
PARTS = 5  # of an exposure, in each of which the light stands still
MARGIN_PX = 96  # px of the shore around what the camera sees when it points at the light


@dataclass(frozen=True)
class PanTiltCamera:
    """
    What a camera on a pan/tilt sees of a light, and of the shore behind it.

    The light is drawn where it is in each part of the exposure, so that it is smeared as the
    camera turns. The shore is shifted and turned with it, as a whole and once a frame. With a
    rolling shutter (`sensor.row_time`) both are seen when the row is exposed in which the light
    lies, and not sheared.

    Parameters
    ----------
    model : CameraModel
        The lens.
    ride : Ride
        How the vehicle turns.
    light : callable
        From times (n,) in s to (n, 3) unit vectors onto the light, in the level frame.
    sigma, amplitude : float
        Of the light's image: standard deviation, px, and peak above the background, DN.
    profile : Profile
        Shape of the image.
    background, texture : float
        Mean of the shore and standard deviation of its pattern, DN.
    sensor : Sensor
        What turns light into numbers.
    exposure : float
        s.
    chain : AnalogueChain
        Line jitter and trailing edge of an analogue camera of 480 lines; none as it stands. The
        grabber's own clock is left out: it is one scale for all pictures, which a calibration has.
    region : (int, int)
        Width and height of the hardware crop in the middle of the sensor, px.
    seed : int
        Of texture and noise.

    """

    model: CameraModel
    ride: Ride
    light: Callable[[Array], Array]
    sigma: float
    amplitude: float
    profile: Profile = Gaussian()
    background: float = 40.0
    texture: float = 8.0
    sensor: Sensor = Sensor()
    exposure: float = 0.002
    chain: AnalogueChain = AnalogueChain()
    region: tuple[int, int] = (160, 120)
    seed: int = 1

    def times(self, middle: float) -> Array:
        """Return the middles of the parts of an exposure about a time, s."""
        return middle + self.exposure * ((np.arange(PARTS) + 0.5) / PARTS - 0.5)

    def rays(self, times: Array, joints: Array) -> Array:
        """
        Return the directions in which the camera sees the light.

        Parameters
        ----------
        times : (n,) array
            s.
        joints : (n, 2) array
            Where pan and tilt truly are at these times, rad.

        Returns
        -------
        (n, 3) array
            Unit vectors of the camera's optical frame.

        """
        in_base = np.einsum('nji,nj->ni', self.ride.rotations(times), self.light(times))
        return np.asarray(np.einsum('nji,nj->ni', camera_turns(joints), in_base))

    def off_axis(self, times: Array, joints: Array) -> Array:
        """Return the (n,) angles between the optical axis and the light, rad."""
        x, y, z = self.rays(times, joints).T
        return np.asarray(np.arctan2(np.hypot(x, y), z))

    @property
    def readout(self) -> float:
        """From the exposure of the first row to that of the last, s."""
        return self.sensor.row_time * (self.region[1] - 1)

    def seen(self, first: float, joints: Turned) -> float:
        """
        Return the middle of the exposure of the row in which the light lies, s.

        Parameters
        ----------
        first : float
            That of the first row, s.
        joints : callable
            From times (n,) in s to pan and tilt (n, 2), rad.

        """
        time = first
        top = (self.model.height - self.region[1]) // 2
        for _ in range(ROUNDS if self.sensor.row_time else 0):
            times = np.array([time])
            row = self.model.project(self.rays(times, joints(times)))[0, 1] - top
            if np.isfinite(row):
                time = first + self.sensor.row_time * min(max(row, 0.0), self.region[1] - 1.0)
        return time

    def frame(self, index: int, first: float, joints: Turned, *, lit: bool | Waveform) -> Frame:
        """
        Take a picture.

        Parameters
        ----------
        index : int
            Of the frame: its noise.
        first : float
            Middle of the exposure of its first row, s.
        joints : callable
            From times (n,) in s, of the whole exposure, to pan and tilt (n, 2), rad.
        lit : bool or Waveform
            Whether the light is on; or how it blinks, in parts of its amplitude.

        Returns
        -------
        Frame
            With the stamp of `first`, counted from 1 s on.

        """
        width, height = self.region
        left, top = (self.model.width - width) // 2, (self.model.height - height) // 2
        middle = self.seen(first, joints)
        times = self.times(middle)
        turned = joints(times)
        places = self.model.project(self.rays(times, turned))
        picture = self._shore(middle, turned[PARTS // 2], places[PARTS // 2])
        parts = (
            mean_over(lit, times, self.exposure / PARTS) if callable(lit)
            else np.full(PARTS, float(lit))
        )
        if parts.any():
            random = np.random.Generator(np.random.SFC64([self.seed, index, 1]))
            lines = jittering_offsets(
                self.chain.offsets()[top:top + height], random, per_line=self.chain.per_line,
                per_frame=self.chain.per_frame,
            )
            for (x, y), part in zip(places.tolist(), parts.tolist()):
                self._add(picture, x - left, y - top, part, lines)
        if self.chain.trailing_edge is not None:
            picture = peaked(picture, self.chain.trailing_edge).astype(np.float32)
        pixels = self.sensor.expose(picture, NoiseBank(self.seed, index))
        return Frame(
            pixels, 10**9 + round(1e9 * first), self.sensor.saturation, left, top,
            exposure_ns=round(1e9 * self.exposure), line_time_ns=1e9 * self.sensor.row_time,
        )

    def _add(
        self, picture: NDArray[np.float32], x: float, y: float, lit: float, lines: Array
    ) -> None:
        """Add a part of an exposure, lit for so much of it; each line sees it at its offset."""
        if not (np.isfinite(x) and np.isfinite(y)):
            return
        half = ceil(self.profile.reach * self.sigma)
        left, top = max(round(x) - half, 0), max(round(y) - half, 0)
        part = picture[top:max(round(y) + half + 1, 0), left:max(round(x) + half + 1, 0)]
        if part.size:
            part += (lit * self.amplitude / PARTS * self.profile.over_pixels(
                (part.shape[0], part.shape[1]), x - left + lines[top:top + len(part)], y - top,
                self.sigma, sqrt(self.sensor.fill_factor),
            )).astype(np.float32)

    def _shore(self, middle: float, joints: Array, place: Array) -> NDArray[np.float32]:
        """Return the (h, w) shore behind the light: it is as far away, and turns about it."""
        width, height = self.region
        if self.texture == 0.0:
            return np.full((height, width), self.background, dtype=np.float32)
        (left, top) = (self.model.width - width) // 2, (self.model.height - height) // 2
        camera = self.ride.rotations(np.array([middle]))[0] @ camera_turns(joints[None])[0]
        # The level frame's y seen by the camera: how far the picture is turned about its axis.
        roll = np.arctan2(camera[1, 0], camera[1, 1])
        cosine, sine = np.cos(roll), np.sin(roll)
        wall = _shore(width, height, self.background, self.texture, self.seed)
        middle_x, middle_y = 0.5 * wall.shape[1], 0.5 * wall.shape[0]
        x, y = place - (left, top)
        # From the picture to the shore; far off the light's surroundings are not the point.
        back = np.array([
            [cosine, -sine, middle_x - cosine * x + sine * y],
            [sine, cosine, middle_y - sine * x - cosine * y],
        ])
        return np.asarray(cv2.warpAffine(
            wall, back, (width, height), flags=cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REFLECT_101,
        ))


def camera_turns(joints: Array) -> Array:
    """Return (n, 3, 3) turns of the camera's components to the base's at (n, 2) pan and tilt."""
    return turn_about(1, joints[:, 0]) @ turn_about(0, joints[:, 1])


@lru_cache(maxsize=4)
def _shore(
    width: int, height: int, background: float, texture: float, seed: int
) -> NDArray[np.float32]:
    """Return the mean signal of the shore, DN, with a margin on each side."""
    return textured_wall(
        (height + 2 * MARGIN_PX, width + 2 * MARGIN_PX), background=background, texture=texture,
        seed=seed,
    )
