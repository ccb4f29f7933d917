"""NEES of the bearing: windows all over a distorting lens' picture, located and made angles."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.accuracy import nees, target_scenes, Tick
from benchmarks.ours import CHAMPION, estimate
from benchmarks.scenes import sample
from blob_tracker.camera.model import CameraModel, pinhole_matrix
from blob_tracker.types import Location
from blob_tracker.units import MRAD_PER_RAD
import cv2
import numpy as np
from numpy.typing import NDArray

WIDTH, HEIGHT, FOCAL_LENGTH = 1280, 720, 900.0  # px: 71 degrees across
# A wide lens with barrel distortion, somewhat off its axis: 110 px in a corner.
LENS = CameraModel(
    WIDTH,
    HEIGHT,
    pinhole_matrix(FOCAL_LENGTH, WIDTH, HEIGHT),
    np.array([-0.28, 0.09, 1e-3, -5e-4, -0.01]),
)
MARGIN = 20  # px between a blob and the picture's edge


@dataclass(frozen=True)
class Row:
    """
    The default method's bearings on one of the target's scenes.

    Parameters
    ----------
    scene : str
        Window and SNR.
    nees : float
        Mean of e^T Cov^-1 e of azimuth and elevation, 2 where the covariance in mrad^2 is true.
    rms : float
        Of azimuth and elevation together, mrad.
    count : int
        Bearings.

    """

    scene: str
    nees: float
    rms: float
    count: int


def run(count: int, tick: Tick) -> list[Row]:
    """Return a row for each of the target's scenes, from `count` bearings each."""
    rows = []
    for seed, (name, scene) in enumerate(target_scenes().items()):
        tick(f'bearing {name}')
        angles, pixels = directions(count, np.random.default_rng(1000 + seed))
        corner = np.rint(pixels) - (scene.window - 1) // 2
        places = pixels - np.rint(pixels)
        found = estimate(sample(scene, count, 1000 + seed, places).windows, CHAMPION)
        seen = [
            LENS.bearing(
                Location(
                    x=found.x[index] + corner[index, 0],
                    y=found.y[index] + corner[index, 1],
                    covariance=found.covariance[index],
                    amplitude=found.amplitude[index],
                    background=found.background[index],
                    sigma=found.sigma[index],
                    snr=found.snr[index],
                    chi2=found.chi2[index],
                    saturated=found.saturated[index],
                )
            )
            for index in np.flatnonzero(found.ok)
        ]
        errors = np.array([[each.azimuth, each.elevation] for each in seen]) - angles[found.ok]
        stated = np.array([each.covariance for each in seen])
        rms = float(np.sqrt(np.mean(errors**2)))
        rows.append(Row(name, nees(errors, stated), rms, len(errors)))
    return rows


def steps() -> int:
    """Return how many ticks `run` makes."""
    return len(target_scenes())


def directions(
    count: int, random: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """
    Return (count, 2) true azimuth and elevation, mrad, and the pixels that they are imaged on.

    Forward through the lens, by OpenCV: the way that CameraModel has to find back.
    """
    found = np.empty((0, 2)), np.empty((0, 2))
    # A fifth beyond the ideal lens' field of view: the barrel draws the edges in.
    limits = 1.2 * np.arctan(np.array([WIDTH, HEIGHT]) / (2 * FOCAL_LENGTH))
    while len(found[0]) < count:
        angles = random.uniform(-limits, limits, (2 * count, 2))
        azimuth, elevation = angles.T
        rays = np.stack(
            [
                np.sin(azimuth) * np.cos(elevation),
                -np.sin(elevation),
                np.cos(azimuth) * np.cos(elevation),
            ],
            axis=1,
        )
        origin = np.zeros(3)
        pixels, _ = cv2.projectPoints(rays, origin, origin, LENS.matrix, LENS.distortion)
        pixels = pixels[:, 0]
        inside = (np.abs(pixels - np.array([WIDTH - 1, HEIGHT - 1]) / 2)
                  < np.array([WIDTH, HEIGHT]) / 2 - MARGIN).all(axis=1)
        found = (
            np.concatenate([found[0], MRAD_PER_RAD * angles[inside]]),
            np.concatenate([found[1], pixels[inside]]),
        )
    return found[0][:count], found[1][:count]
