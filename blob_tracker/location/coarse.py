"""A wide window at a coarser pitch, at which models are told apart in bounded time."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.location.hypotheses import Fit, Motion, Pair, Way
from blob_tracker.location.noise import noise_of_sum
from blob_tracker.location.pair_model import AMPLITUDE, BACKGROUND, SIGMA, X, Y
import numpy as np
from numpy.typing import NDArray

# px along the shorter side that are left at least. The segmenter cuts windows of six sigmas and
# more, so that a Gaussian of eight of them loses a thousandth of what is known of its place. Of
# the sharp edge of a wide disc a third is lost.
FEWEST = 48
WIDEST = 2 * FEWEST - 1  # px along it, up to which a window stays as it is

Floats = NDArray[np.float64]


def coarse(pair: Pair, theta: Floats | None) -> tuple[Pair, Floats | None]:
    """
    Return a pair whose pixels are sums over p x p of those of a wide one, and its round pulse.

    Parameters
    ----------
    pair : Pair
        Of (h, w) pixels. p is min(h, w) / FEWEST, rounded down; with 1 it is returned.
    theta : (5,) array or None
        x, y, amplitude, background and sigma of a pulse in it.

    """
    pitch = min(pair.lit.shape) // FEWEST
    if pitch < 2:
        return pair, theta
    limit = pitch**2 * pair.saturation
    if pair.sites is not None:
        # A cell that is not all of samples tells less than it seems to.
        pair = replace(pair, lit=np.where(pair.sites, pair.lit, pair.saturation), sites=None)
    history, way = pair.history, pair.way
    if history.motion is not None:
        known = history.motion
        place = None if known.place is None else _place(known.place, pitch)
        history = replace(
            history, motion=Motion(known.flash / pitch, known.deviation / pitch, place)
        )
    if way is not None:
        way = Way(way.length / pitch, way.deviation / pitch, way.bend / pitch)
    summed = Pair(
        _summed(pair.lit, pitch, pair.saturation, limit),
        None if pair.unlit is None else _summed(pair.unlit, pitch, pair.saturation, limit),
        noise_of_sum(pair.noise, pitch**2), limit, history, way, pitch, haunted=pair.haunted,
    )
    if theta is None:
        return summed, None
    theta = theta.copy()
    theta[[X, Y]] = _place(theta[[X, Y]], pitch)
    theta[[AMPLITUDE, BACKGROUND]] *= pitch**2
    theta[SIGMA] /= pitch
    return summed, theta


def fine(fit: Fit, pitch: int) -> Fit:
    """Return a fit of a pair of that pitch as one of the window that it was made of."""
    middle = 0.5 * (pitch - 1)
    return replace(
        fit, x=pitch * fit.x + middle, y=pitch * fit.y + middle,
        covariance=pitch**2 * fit.covariance, amplitude=fit.amplitude / pitch**2,
        background=fit.background / pitch**2, sigma=pitch * fit.sigma, snr=fit.snr / pitch,
        drawn=pitch * fit.drawn, way=None if fit.way is None else pitch * fit.way,
    )


def _place(place: Floats, pitch: int) -> Floats:
    return (place - 0.5 * (pitch - 1)) / pitch


def _summed(pixels: Floats, pitch: int, saturation: float, limit: float) -> Floats:
    """Return the sums of p x p pixels; `limit` where one of them is clipped."""
    height, width = (side // pitch for side in pixels.shape)
    cells = pixels[:height * pitch, :width * pitch].reshape(height, pitch, width, pitch)
    clipped = (cells >= saturation).any(axis=(1, 3))
    return np.where(clipped, limit, cells.sum(axis=(1, 3)))
