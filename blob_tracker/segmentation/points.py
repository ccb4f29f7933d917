"""Candidates of a frame as points: place, its covariance, and how much light."""

from __future__ import annotations

from collections.abc import Sequence
import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.description import distance2
from blob_tracker.types import Pixels
import numpy as np

# Standard deviations of a pixel, texture among them, that a light stands above them
LEAST_PEAK_SIGMA = 5.0
APERTURE = 3.5  # sigma of a blob within which its light is summed
PLACE_FRACTION = 0.02  # of its sigma, by which a blob's centre is off beside its noise
LEAST_PLACE_PX = 0.02  # px: of the centre of any blob
FLANKS_FRACTION = 0.05  # of a clipped blob's height, by which its flanks tell it wrongly


def points(
    contrast: Contrast, candidates: Sequence[Candidate], noise: float
) -> tuple[Array, float]:
    """Return the (n, 7) points of `BlinkTracker.update`, and the flux that is just seen."""
    table = np.zeros((len(candidates), 7))
    faintest = math.inf
    for values, each in zip(table, candidates):
        flux, count = aperture_sum(
            contrast.lit, contrast.unlit, each.x, each.y, each.sigma_x, each.sigma_y,
            each.correlation, each.background / contrast.unit,
        )
        noise_of_flux = each.noise * math.sqrt(count)
        column, row = each.peak
        if contrast.lit[row, column] >= contrast.saturation:
            flux, doubt = unclipped_flux(flux, each.height, each.amplitude)
            noise_of_flux += doubt * contrast.unit
        part = PLACE_FRACTION**2 + 2.0 / max(each.snr, 1.0) ** 2
        xx = each.sigma_x**2 * part + LEAST_PLACE_PX**2
        yy = each.sigma_y**2 * part + LEAST_PLACE_PX**2
        xy = each.correlation * each.sigma_x * each.sigma_y * part
        values[:] = each.x, each.y, xx, xy, yy, flux * contrast.unit, noise_of_flux
        area = 2.0 * math.pi * each.sigma_minor**2
        faintest = min(faintest, area)
    # A peak of five standard deviations of a pixel is found.
    area = faintest if math.isfinite(faintest) else 2.0 * math.pi
    return table, LEAST_PEAK_SIGMA * noise * area


def unclipped_flux(clipped: float, height: float, amplitude: float) -> tuple[float, float]:
    """
    Return the light of a blob of which the top is clipped, and the standard deviation of that.

    A Gaussian of the amplitude A that is clipped at the height M keeps

        S = 2 pi sigma^2 M (1 + ln(A / M))    of    2 pi sigma^2 A.

    Parameters
    ----------
    clipped : float
        S, DN px^2.
    height, amplitude : float
        M, and A as its flanks tell it, DN.

    """
    if not amplitude > height > 0.0:
        return clipped, abs(clipped)
    over = amplitude / height
    flux = clipped * over / (1.0 + math.log(over))
    return flux, FLANKS_FRACTION * abs(flux)


@kernel
def aperture_sum(
    lit: Pixels, unlit: Pixels, x: float, y: float, sigma_x: float, sigma_y: float,
    correlation: float, level: float,
) -> tuple[float, int]:
    """Return the light of a blob above a level within APERTURE sigma, DN px^2, and its pixels."""
    height, width = lit.shape
    reach_x, reach_y = APERTURE * sigma_x, APERTURE * sigma_y
    total, count = 0.0, 0
    for j in range(max(int(y - reach_y), 0), min(int(y + reach_y) + 2, height)):
        for i in range(max(int(x - reach_x), 0), min(int(x + reach_x) + 2, width)):
            if distance2(i - x, j - y, sigma_x, sigma_y, correlation) < APERTURE * APERTURE:
                total += float(lit[j, i]) - float(unlit[j, i]) - level
                count += 1
    return total, count
