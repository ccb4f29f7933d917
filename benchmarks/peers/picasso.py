"""Picasso: maximum likelihood fit of a Gaussian by Levenberg-Marquardt, and the older one."""

from __future__ import annotations

import logging

from benchmarks.contender import Contender
from benchmarks.windows import Positions, Windows
import numpy as np
from numpy.typing import NDArray

# On a machine without loudspeakers an import of Picasso's logs an error that is none.
logging.getLogger('playsound3').setLevel(logging.CRITICAL)

from picasso import gaussmle  # noqa: E402, I100, I202
from picasso.fitting import gaussfit, seeds  # noqa: E402, I100, I202

# The schedule of picasso.localize for this estimator on a CPU.
TOLERANCE, ITERATIONS = 1e-5, 100


def _electrons(windows: Windows) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """
    Return the pixels in electrons and their variance beyond the shot noise of the fitted mean.

    Without an unlit window this is read noise and quantisation; with one the pixels are lit
    less unlit, and the shot noise of the ambient light, twice, comes on top.
    """
    gain = windows.noise.gain
    fixed = (windows.noise.read_noise**2 + 1 / 12) * gain**2
    pixels = windows.lit.astype(np.float32) * np.float32(gain)
    if windows.unlit is None:
        return pixels, np.full(pixels.shape, fixed, dtype=np.float32)
    ambient = windows.unlit.astype(np.float32) * np.float32(gain)
    return pixels - ambient, 2 * ambient + np.float32(2 * fixed)


def _fit(windows: Windows, model: int) -> Positions:
    pixels, variance = _electrons(windows)
    pixels = np.maximum(pixels, -variance)
    start = seeds.initial_parameters_gauss(
        np.maximum(pixels, 0), pixels.shape[1], spherical=model == gaussfit.SPHERICAL
    )
    parameters, *_ = gaussfit.fit_spots(
        model,
        pixels,
        start,
        mle=True,
        tolerance=TOLERANCE,
        max_iterations=ITERATIONS,
        variance=variance,
    )
    return parameters[:, 1], parameters[:, 2]


def _spherical(windows: Windows) -> Positions:
    return _fit(windows, gaussfit.SPHERICAL)


def _elliptic(windows: Windows) -> Positions:
    return _fit(windows, gaussfit.ELLIPTIC)


def _integrated(windows: Windows) -> Positions:
    # It takes no variance; but shifting pixels and mean by one is the same model (Huang et al.,
    # Nature Methods 10 (2013), eq. 3.6), and its background takes a shift that is even.
    pixels, variance = _electrons(windows)
    shifted = pixels + variance.mean(axis=(1, 2), keepdims=True)
    parameters, *_ = gaussmle._gaussmle(np.maximum(shifted, 0), 1e-3, 100, 'sigma')
    return parameters[:, 0], parameters[:, 1]


_FIT = 'DN times gain, read noise and quantisation as variance, schedule of picasso.localize'
PEERS = (
    Contender('Picasso gaussfit', f'MLE, circular; {_FIT}', _spherical),
    Contender('Picasso gaussfit elliptic', f'MLE, elliptical; {_FIT}', _elliptic),
    Contender(
        'Picasso gaussmle',
        'MLE, circular, pixel-integrated; DN times gain plus the variance of the fixed noise',
        _integrated,
        share=0.3,
    ),
)
