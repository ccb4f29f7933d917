"""This project's methods as contenders."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

from benchmarks.contender import Contender, Covariances
from benchmarks.windows import Positions, Windows
from blob_tracker.location import Estimates, locate, locate_batch, METHODS
from blob_tracker.types import LocationError, SensorNoise, Window
import numpy as np

# A simplex takes thousands of evaluations of the model, Levenberg-Marquardt a hundred.
SHARES = {'multi_gaussian_simplex': 0.002, 'multi_gaussian_lm': 0.01}
ELLIPTICAL = ('maximum_likelihood',)
CHAMPION = 'maximum_likelihood'  # the method that the targets are for
LIT_ONLY, DIFFERENCE = f'{CHAMPION}, lit only', f'{CHAMPION}, difference'


def contenders() -> list[Contender]:
    """Return every method of the registry, and the elliptical form of those in ELLIPTICAL."""
    plain = [_contender(method, method, {}) for method in METHODS]
    elliptical = [
        _contender(f'{method} elliptical', method, {'elliptical': True})
        for method in ELLIPTICAL
        if method in METHODS
    ]
    return plain + elliptical


def texture_references() -> list[Contender]:
    """Return the two pure choices that the choice made per blob is held against."""
    return [
        Contender(LIT_ONLY, 'the unlit window withheld', _lit_only),
        Contender(DIFFERENCE, 'lit less unlit, with the noise of both', _difference),
    ]


def estimate(windows: Windows, method: str, **options: Any) -> Estimates:
    """Return what the method finds in the windows."""
    return locate_batch(
        windows.lit,
        windows.unlit,
        method=method,
        noise=windows.noise,
        saturation=windows.saturation,
        **options,
    )


def _contender(name: str, method: str, options: dict[str, Any]) -> Contender:
    setting = 'gain, read noise and full scale of the sensor'
    return Contender(
        name,
        setting,
        partial(_positions, method=method, options=options),
        share=SHARES.get(method, 1.0),
        single=partial(_single, method=method, options=options),
        covariance=partial(_covariances, method=method, options=options),
    )


def _positions(windows: Windows, *, method: str, options: dict[str, Any]) -> Positions:
    found = estimate(windows, method, **options)
    return np.where(found.ok, found.x, np.nan), np.where(found.ok, found.y, np.nan)


def _covariances(windows: Windows, *, method: str, options: dict[str, Any]) -> Covariances:
    return estimate(windows, method, **options).covariance


def _lit_only(windows: Windows) -> Positions:
    return _positions(replace(windows, unlit=None), method=CHAMPION, options={})


def _difference(windows: Windows) -> Positions:
    """Locate in lit - unlit + u, whose variance is that of its mean plus u / gain and a read."""
    noise = windows.noise
    assert windows.unlit is not None
    level = float(windows.unlit.mean())
    fixed = np.sqrt(level / noise.gain + 2 * noise.read_noise**2 + 1 / 12)
    lit = windows.lit.astype(float) - windows.unlit + level
    twice = SensorNoise(noise.gain, float(fixed))
    return _lit_only(replace(windows, lit=lit, noise=twice))


def _single(windows: Windows, *, method: str, options: dict[str, Any]) -> object:
    unlit = None if windows.unlit is None else windows.unlit[0]
    window = Window(windows.lit[0], unlit, saturation=windows.saturation)
    try:
        return locate(window, method=method, noise=windows.noise, **options)
    except LocationError:
        return None
