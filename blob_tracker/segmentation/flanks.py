"""What of an over-exposed blob is left: its flanks, and the Gaussian that they belong to."""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel
from blob_tracker.types import Pixels
import numpy as np

LEAST_NOISES = 5.0  # standard deviations: the logarithm of less is no measure of the light
UNKNOWNS = 4  # of a circular Gaussian without its background
UNKNOWN_MISFIT = 1e9  # where no Gaussian fits


@kernel
def flank_misfit(
    lit: Pixels,
    unlit: Pixels,
    region: tuple[int, int, int, int],
    step: int,
    x: float,
    y: float,
    level: float,
    noise: float,
    saturation: int,
) -> tuple[float, float]:
    """
    Return what the Gaussian of a clipped blob's flanks leaves unexplained, and its height.

    On the pixels I that are not clipped the Gaussian is a parabola,

        ln I = a + b u + c v - d (u^2 + v^2),

    fitted with the weights I^2, because the noise of ln I is that of I over I. What it leaves is
    compared with all of the light that is seen, the flat top included.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN, C-contiguous, of one type.
    region : (int, int, int, int)
        Columns x0 to x1 and rows y0 to y1 of the blob, px.
    step : int
        Only every so many pixels are looked at.
    x, y : float
        About where the blob is, px.
    level, noise : float
        Background and standard deviation of lit less unlit, DN.
    saturation : int
        The DN at which a pixel is clipped.

    Returns
    -------
    misfit : float
        rms over rms of the light; 1e9 where the flanks are no Gaussian's.
    height : float
        Of the Gaussian, DN.

    """
    left, top, right, bottom = region
    matrix = np.zeros((UNKNOWNS, UNKNOWNS + 1))
    terms = np.empty(UNKNOWNS + 1)
    count = 0
    for j in range(top, bottom, step):
        for i in range(left, right, step):
            rise = float(lit[j, i]) - float(unlit[j, i]) - level
            if lit[j, i] >= saturation or rise < LEAST_NOISES * noise:
                continue
            u, v = i - x, j - y
            terms[0], terms[1], terms[2], terms[3] = 1.0, u, v, -(u * u + v * v)
            terms[4] = np.log(rise)
            for p in range(UNKNOWNS):
                for q in range(UNKNOWNS + 1):
                    matrix[p, q] += rise * rise * terms[p] * terms[q]
            count += 1
    if count <= UNKNOWNS or not _eliminated(matrix):
        return UNKNOWN_MISFIT, 0.0
    a, b, c, d = matrix[0, 4], matrix[1, 4], matrix[2, 4], matrix[3, 4]
    height = a + 0.25 * (b * b + c * c) / d if d > 0.0 else np.inf
    if height > 50.0:  # of the logarithm
        return UNKNOWN_MISFIT, 0.0
    misfit, light, count = 0.0, 0.0, 0
    for j in range(top, bottom, step):
        for i in range(left, right, step):
            u, v = i - x, j - y
            most = saturation - float(unlit[j, i]) - level
            model = min(np.exp(min(a + b * u + c * v - d * (u * u + v * v), 50.0)), most)
            light += model * model
            if lit[j, i] < saturation:
                residual = float(lit[j, i]) - float(unlit[j, i]) - level - model
                misfit += residual * residual
                count += 1
    misfit -= (count + 5.0 * np.sqrt(2.0 * count)) * noise * noise
    if light <= 0.0:
        return UNKNOWN_MISFIT, 0.0
    return np.sqrt(max(misfit, 0.0) / light), np.exp(height)


@kernel
def _eliminated(matrix: Array) -> bool:
    """Solve in place by Gauss and Jordan, the solution in the last column; False where none is."""
    size = matrix.shape[0]
    for p in range(size):
        best = p
        for q in range(p + 1, size):
            if abs(matrix[q, p]) > abs(matrix[best, p]):
                best = q
        if abs(matrix[best, p]) < 1e-9 * abs(matrix[0, 0]) or matrix[best, p] == 0.0:
            return False
        for k in range(size + 1):
            matrix[p, k], matrix[best, k] = matrix[best, k], matrix[p, k]
        for q in range(size):
            if q != p:
                factor = matrix[q, p] / matrix[p, p]
                for k in range(p, size + 1):
                    matrix[q, k] -= factor * matrix[p, k]
    for p in range(size):
        matrix[p, size] /= matrix[p, p]
    return True
