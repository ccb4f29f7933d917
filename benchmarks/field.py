"""A real frame with many blobs whose true places are known up to a smooth map."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.windows import Positions, Windows
import numpy as np
from numpy.typing import NDArray

OUTLIER = 4.0  # robust standard deviations
ROUNDS = 10
NOISE = 0.75  # px times SNR: about the Cramer-Rao bound of a blob with sigma 0.6 px
SYSTEMATIC = 0.03  # px: what remains of the brightest stars


@dataclass(frozen=True)
class Field:
    """
    The windows of one frame.

    Parameters
    ----------
    name : str
        Of the frame.
    windows : Windows
        One for each blob.
    x0, y0 : (N,) arrays
        Place of each window's first pixel in the frame, px.
    u, v : (N,) arrays
        True coordinates: catalogue or grid.
    snr : (N,) array
        Peak SNR of each blob by the catalogue; infinite where it is not noise that limits.
    order : int
        Of the polynomial that maps (u, v) onto pixels.

    """

    name: str
    windows: Windows
    x0: NDArray[np.float64]
    y0: NDArray[np.float64]
    u: NDArray[np.float64]
    v: NDArray[np.float64]
    snr: NDArray[np.float64]
    order: int


@dataclass(frozen=True)
class Residuals:
    """
    What the smooth map leaves of one contender's positions in one field.

    Parameters
    ----------
    x, y : (N,) arrays
        Located less mapped, px; NaN where nothing was found or the blob is an outlier.
    phase_x, phase_y : (N,) arrays
        Mapped place less the middle of its pixel, px.
    freedom : float
        Factor by which the map's degrees of freedom shrink the rms of the residuals.

    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    phase_x: NDArray[np.float64]
    phase_y: NDArray[np.float64]
    freedom: float


def cut(
    frame: NDArray[np.generic], x0: NDArray[np.intp], y0: NDArray[np.intp], side: int
) -> NDArray[np.generic]:
    """Return the (N, side, side) windows of the frame whose first pixels are given."""
    views = np.lib.stride_tricks.sliding_window_view(frame, (side, side))
    return np.ascontiguousarray(views[y0, x0])


def residuals(field: Field, positions: Positions) -> Residuals:
    """
    Fit the map to the positions and return what it leaves.

    Each blob weighs by what it can be expected to show, the same for every contender: NOISE over
    its SNR, and SYSTEMATIC. Blobs farther off than OUTLIER robust standard deviations are left
    out and the map fitted again, until the same ones stay. (The median of a Rayleigh distance is
    1.177 sigma.)
    """
    located = np.stack([positions[0] + field.x0, positions[1] + field.y0], axis=1)
    terms = _polynomial(field.u, field.v, field.order)
    weight = 1.0 / np.hypot(NOISE / field.snr, SYSTEMATIC)[:, None]
    found = np.isfinite(located).all(axis=1)
    kept = found
    for _ in range(ROUNDS):
        weighted = (terms * weight)[kept], (located * weight)[kept]
        mapped = terms @ np.linalg.lstsq(*weighted, rcond=None)[0]
        left = located - mapped
        distance = np.hypot(*(left * weight).T)
        limit = OUTLIER * np.median(distance[kept]) / 1.177
        again = found & (np.nan_to_num(distance, nan=np.inf) <= limit)
        if (again == kept).all():
            break
        kept = again
    count, unknown = int(kept.sum()), terms.shape[1]
    # A map with as many unknowns as blobs passes through all of them and tells nothing.
    left[~kept if count > unknown else slice(None)] = np.nan
    freedom = float(np.sqrt(count / max(count - unknown, 1)))
    phase = mapped - np.rint(mapped)
    return Residuals(left[:, 0], left[:, 1], phase[:, 0], phase[:, 1], freedom)


def _polynomial(
    u: NDArray[np.float64], v: NDArray[np.float64], order: int
) -> NDArray[np.float64]:
    """Return (N, terms): Legendre products up to the order, on coordinates scaled to +-1."""
    scaled = [2 * (axis - axis.min()) / np.ptp(axis) - 1 for axis in (u, v)]
    across, down = (np.polynomial.legendre.legvander(axis, order) for axis in scaled)
    return np.stack(
        [across[:, i] * down[:, j] for i in range(order + 1) for j in range(order + 1 - i)],
        axis=1,
    )
