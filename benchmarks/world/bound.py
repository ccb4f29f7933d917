"""
The Cramer-Rao bound of any model that can be drawn.

`benchmarks.bound` is that of a lone Gaussian; here the model is a function, and its derivatives
are differences of two drawings.
"""

from __future__ import annotations

from benchmarks.world.situation import Floats, Model
from blob_tracker.location.noise import pixel_variance
import numpy as np

STEP = 1e-4  # of a parameter, and at least of 1; a central difference errs by its square
BLIND = 1e-10  # of the largest eigenvalue: what tells nothing costs nothing


def bound(model: Model) -> Floats:
    """
    Return the least covariance of x and y that an unbiased estimate can have, (2, 2) px^2.

    I_pq = sum_k (d mu_k/d p)(d mu_k/d q) / v_k with the variance v_k of a pixel's mean (Huang et
    al., Nature Methods 10 (2013), eq. 3.6), over all pixels of all images that the model draws,
    inverted. All other parameters are unknown as well; one of which the pixels tell nothing is
    left out.

    Parameters
    ----------
    model : Model
        The expected images and the true parameters.

    """
    steps = np.diag(STEP * np.maximum(np.abs(model.parameters), 1.0))
    slopes = np.stack([
        (model.mean(model.parameters + step) - model.mean(model.parameters - step)).ravel()
        / (2.0 * step.sum())
        for step in steps
    ])
    weight = 1.0 / pixel_variance(model.mean(model.parameters), model.noise).ravel()
    if model.used is not None:
        weight = np.where(model.used.ravel(), weight, 0.0)
    information = (slopes * weight) @ slopes.T
    # Of unit diagonal: amplitudes and places differ by orders of magnitude.
    scale = np.sqrt(np.diag(information))
    seen = scale > BLIND * scale.max()
    scale = scale[seen]
    inverse = np.linalg.pinv(
        information[np.ix_(seen, seen)] / np.outer(scale, scale), rcond=BLIND, hermitian=True
    )
    covariance: Floats = (inverse / np.outer(scale, scale))[:2, :2]
    return covariance
