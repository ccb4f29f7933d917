"""The same frames of a flashing light, written in each of the formats that are read."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from astropy.io.fits import PrimaryHDU
from blob_tracker.simulation import flashing_light
import cv2
import numpy as np
import tifffile

RATE = 30.0  # Hz
WIDTH, HEIGHT = 112, 88
FIRST = np.datetime64('2026-01-02T03:04:05', 'ns')
EXPOSURE_S = 0.01


def light_frames(count: int) -> list[np.ndarray]:
    """Return frames of 8 bits in which a light is on in every other one."""
    scene = flashing_light(
        width=WIDTH, height=HEIGHT, rate=RATE, sigma=1.6, seed=7, period=5.0
    )
    return [scene.frame(index) for index in range(count)]


def folder(path: Path, frames: Sequence[np.ndarray]) -> Path:
    """Write a folder of PNG."""
    path.mkdir()
    for index, frame in enumerate(frames):
        assert cv2.imwrite(str(path / f'{index}.png'), frame)
    return path


def video(path: Path, frames: Sequence[np.ndarray]) -> Path:
    """Write a video without losses."""
    height, width = frames[0].shape
    code = cv2.VideoWriter.fourcc(*'FFV1')
    writer = cv2.VideoWriter(str(path), code, RATE, (width, height))
    for frame in frames:
        writer.write(cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR))
    writer.release()
    return path


def tiff(path: Path, frames: Sequence[np.ndarray], **options: Any) -> Path:
    """Write a TIFF of pages, as tifffile's options have it."""
    tifffile.imwrite(path, np.array(frames), **options)
    return path


def fits(path: Path, pixels: np.ndarray, **header: object) -> Path:
    """Write a FITS file of one picture, or of a cube."""
    unit = PrimaryHDU(pixels)
    for key, value in header.items():
        unit.header[key.replace('_', '-')] = value
    unit.writeto(path)
    return path


def dated_fits(path: Path, frames: Sequence[np.ndarray]) -> Path:
    """Write a folder of FITS files that tell when each was exposed."""
    path.mkdir()
    for index, frame in enumerate(frames):
        begin = FIRST + np.timedelta64(round(1e9 * index / RATE), 'ns')
        fits(path / f'{index}.fits', frame, DATE_OBS=str(begin), EXPTIME=EXPOSURE_S)
    return path
