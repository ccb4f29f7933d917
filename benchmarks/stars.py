"""Star frames with catalogue positions: undersampled, sigma about 0.63 px."""

from __future__ import annotations

from pathlib import Path

from benchmarks.field import cut, Field
from benchmarks.windows import Windows
from blob_tracker.types import SensorNoise
import cv2
import numpy as np

SIDE = 7  # px
ALONE = 10.0  # px to the next catalogue star
# From the frames' own sky: its noise goes from 7.3 DN at 141 DN to 9.4 DN at 210 DN.
NOISE = SensorNoise(gain=3.0, read_noise=2.0)
FULL_SCALE = 4095
SIGMA = 0.63


def fields(data: Path) -> list[Field]:
    """Return a field for each frame of the folder: the stars that stand alone."""
    return [_field(path) for path in sorted((data / 'stars').glob('*.csv'))]


def _field(path: Path) -> Field:
    frame = cv2.imread(str(path.with_suffix('.png')), cv2.IMREAD_UNCHANGED)
    if frame is None:
        raise FileNotFoundError(f'{path} has no frame {path.stem}.png beside it')
    frame = frame // 16  # 12 bits in the high bits of 16
    table = np.genfromtxt(path, delimiter=',', names=True)
    x0, y0 = (table[name].astype(int) - SIDE // 2 for name in ('x0', 'y0'))
    distance = np.hypot(x0[:, None] - x0, y0[:, None] - y0)
    np.fill_diagonal(distance, np.inf)
    height, width = frame.shape
    kept = (distance.min(axis=1) > ALONE) & (x0 >= 0) & (y0 >= 0)
    kept &= (x0 <= width - SIDE) & (y0 <= height - SIDE)
    return Field(
        path.stem,
        Windows(cut(frame, x0[kept], y0[kept], SIDE), None, NOISE, FULL_SCALE, SIGMA),
        x0[kept].astype(float),
        y0[kept].astype(float),
        table['xi'][kept],
        table['eta'][kept],
        table['peak_snr'][kept],
        order=3,
    )
