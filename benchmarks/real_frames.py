"""What the segmenter finds in whole real frames: a laser line switched on, and stars."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.stars import FULL_SCALE
from blob_tracker.segmentation import Candidate, Detections, flash_by_name, Segmenter
from blob_tracker.types import Frame
import cv2
import numpy as np
from numpy.typing import NDArray

INTERVAL_NS = 33_000_000  # between the frames of a pair; the files bear no stamps
SATURATION = 255
MIN_SNR = 7.0
# Of the pixels whose redness fell: what rose by more than so many fell is the laser's.
WEAK, STRONG = 0.99, 0.999
BACKGROUND = 31  # rows whose median is the redness without the line
LONGEST, FLATTEST = 24, 2  # px that a part of the line is wide at least, times its height
REACH = 7  # px by which the line is widened: its glow and the codec's blocks
BRIGHT = 8.0  # peak SNR of the stars that must be found
NEAR = 1.5  # px from the catalogue's pixel
LASER, STARS = 'laser line', 'stars'


@dataclass(frozen=True)
class Row:
    """
    What was found in one pair, or in one frame of stars.

    Parameters
    ----------
    kind, name : str
        Laser line or stars; of which file.
    found, total : int
        Of one line, whether the highest of all that lit up is on it; of the stars above peak
        SNR 8, those found and not rejected.
    others : int
        Candidates that are not rejected and are off the line, or not in the catalogue.
    strongest_other : float
        SNR in the matched filter of the strongest of them, 0 if there is none.
    windows : int
        Windows off the line; of stars, windows in all.
    reason : str
        Why there is no window.

    """

    kind: str
    name: str
    found: int
    total: int
    others: int
    strongest_other: float
    windows: int
    reason: str


def run(data: Path) -> list[Row]:
    """Return the rows of all pairs and frames in the folder."""
    lit = sorted((data / 'laser_on_off').glob('*-b-*.jpg'))
    return [_laser(path) for path in lit] + [
        _stars(path) for path in sorted((data / 'stars').glob('*.csv'))
    ]


def missed(data: Path) -> list[tuple[str, int, int, Candidate | None]]:
    """Return name and pixel of each bright star that was not found, and what is there instead."""
    out = []
    for path in sorted((data / 'stars').glob('*.csv')):
        table, detections, _ = _sky(path)
        for star in table[table['peak_snr'] > BRIGHT]:
            seen = _at(detections.candidates, star['x0'], star['y0'])
            if seen is None or seen.rejected:
                out.append((path.stem, int(star['x0']), int(star['y0']), seen))
    return out


def line(lit: NDArray[np.uint8], unlit: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """
    Return where the laser line is, from the colours alone.

    Of the difference in redness, red less the mean of green and blue, the median of its column is
    taken off; what rises above all but 0.1 % of the falls, and hangs together with it above 1 % of
    them, is the line where it is wide and flat. The search itself sees no colours.

    Parameters
    ----------
    lit, unlit : (h, w, 3) arrays
        DN in OpenCV's order: blue, green, red.

    Returns
    -------
    (h, w) array
        Whether a pixel is within 3 px of the line.

    """
    redder = _redness(lit) - _redness(unlit)
    smooth = cv2.GaussianBlur(redder, (0, 0), 1.0)
    padded = np.pad(smooth, ((BACKGROUND // 2, BACKGROUND // 2), (0, 0)), mode='reflect')
    columns = np.lib.stride_tricks.sliding_window_view(padded, BACKGROUND, axis=0)
    excess = smooth - np.median(columns, axis=-1)
    strong = excess > np.quantile(-excess, STRONG)
    weak = (excess > np.quantile(-excess, WEAK)).astype(np.uint8)
    count, labels, boxes, _ = cv2.connectedComponentsWithStats(weak, connectivity=8)
    out = np.zeros_like(weak)
    for index in range(1, count):
        _, _, width, height, _ = boxes[index]
        part = labels == index
        if width >= max(LONGEST, FLATTEST * height) and strong[part].any():
            out[part] = 1
    return np.asarray(cv2.dilate(out, np.ones((REACH, REACH), np.uint8)) > 0)


def pair(path: Path) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return the lit and the unlit picture of a pair, (h, w, 3) each, from the lit one's path."""
    return _picture(path), _picture(path.with_name(path.name.replace('-b-', '-a-')))


def _laser(path: Path) -> Row:
    lit, unlit = pair(path)
    truth = line(lit, unlit)
    segmenter = Segmenter(flash=flash_by_name('alternate'), min_snr=MIN_SNR)
    windows = 0
    for index, picture in enumerate((unlit, lit)):
        grey = np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8)
        window = segmenter.update(Frame(grey, index * INTERVAL_NS, SATURATION))
        if window is not None:
            height, width = window.lit.shape
            windows += not truth[window.y0 + height // 2, window.x0 + width // 2]
    assert segmenter.detections is not None
    candidates = segmenter.detections.candidates
    highest = max(candidates, key=lambda each: each.height, default=None)
    picked = highest is not None and truth[highest.peak[::-1]]
    others = [each for each in candidates if not each.rejected and not truth[each.peak[::-1]]]
    return Row(
        LASER, path.stem, int(picked), 1, len(others), _strongest(others), windows,
        segmenter.reason,
    )


def _stars(path: Path) -> Row:
    table, detections, reason = _sky(path)
    bright = table[table['peak_snr'] > BRIGHT]
    seen = [_at(detections.candidates, star['x0'], star['y0']) for star in bright]
    found = sum(each is not None and not each.rejected for each in seen)
    others = [
        each for each in detections.candidates
        if not each.rejected
        and np.hypot(table['x0'] - each.x, table['y0'] - each.y).min() >= NEAR
    ]
    return Row(
        STARS, path.stem, found, len(bright), len(others), _strongest(others),
        len(detections.windows),
        reason,
    )


def _sky(path: Path) -> tuple[NDArray[np.void], Detections, str]:
    """Return the catalogue of a frame, and what the steady mode sees in it."""
    frame = cv2.imread(str(path.with_suffix('.png')), cv2.IMREAD_UNCHANGED)
    if frame is None:
        raise FileNotFoundError(f'{path} has no frame {path.stem}.png beside it')
    segmenter = Segmenter(flash=flash_by_name('steady'), min_snr=MIN_SNR)
    image = np.asarray(frame // 16, np.uint16)  # 12 bits in the high bits of 16
    segmenter.update(Frame(image, 0, FULL_SCALE))
    assert segmenter.detections is not None
    return np.genfromtxt(path, delimiter=',', names=True), segmenter.detections, segmenter.reason


def _at(candidates: Sequence[Candidate], x: float, y: float) -> Candidate | None:
    """Return the candidate nearest to a place, where one is near."""
    nearest = min(candidates, key=lambda each: np.hypot(each.x - x, each.y - y), default=None)
    if nearest is None or np.hypot(nearest.x - x, nearest.y - y) >= NEAR:
        return None
    return nearest


def _strongest(candidates: Sequence[Candidate]) -> float:
    return max((each.snr for each in candidates), default=0.0)


def _redness(picture: NDArray[np.uint8]) -> NDArray[np.float32]:
    blue, green, red = cv2.split(picture.astype(np.float32))
    return np.asarray(red - 0.5 * (green + blue), np.float32)


def _picture(path: Path) -> NDArray[np.uint8]:
    picture = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if picture is None:
        raise FileNotFoundError(f'{path} is missing, or no picture')
    return np.asarray(picture, np.uint8)
