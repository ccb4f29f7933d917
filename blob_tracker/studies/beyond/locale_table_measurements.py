"""Locales, and locators beside them: the cases of the study measured."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from statistics import median
from time import process_time
from typing import Any

from blob_tracker.location import locate, locate_batch
from blob_tracker.location.limits import cramer_rao_bound, locale_extent
from blob_tracker.location.multi_gaussian import LAMP_AMPLITUDES, LAMP_WIDTHS
from blob_tracker.location.pulse import integrated_profile, sampled_profile
from blob_tracker.simulation.sensor import expose
from blob_tracker.studies.study import Case, Measured
from blob_tracker.types import SensorNoise, Window
import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.float64]
METHODS = ('centroid', 'centroid_skew_corrected', 'locale_table', 'maximum_likelihood')
ROUNDING = SensorNoise(gain=1e9, read_noise=0.0)  # 1/12 DN^2 and nothing else
CAMERA = SensorNoise(gain=20.0, read_noise=0.25)
BACKGROUND_DN = 20.0  # DN
SINGLE_CALLS = 50
SHAPES: dict[str, dict[str, float]] = {
    'Gaussian, sigma 1.5 px': {},
    'Gaussian, sigma 0.5 px': {'sigma': 0.5},
    'Gaussian, 2 px off the middle': {'offset': 2.0},
    'ellipse, axes 1.5 to 1, along the rows': {'ratio': 1.5},
    'ellipse, axes 1.5 to 1, at 45 degrees': {'ratio': 1.5, 'tilt': 45.0},
    "the thesis' three Gaussians, s 1 px": {'three': True},
    'Gaussian, clipped at half its peak': {'clip': 0.5},
}


def cases(quick: bool) -> Sequence[Case]:
    """Return the jobs."""
    count = 4000 if quick else 40000
    cases: list[Case] = [
        {'kind': 'picture', 'amplitude': 5.0, 's': 1.0, 'reach': 0.5, 'nodes': 160},
        {'kind': 'picture', 'amplitude': 255.0, 's': 1.0, 'reach': 0.02, 'nodes': 160},
    ]
    cases += [
        {'kind': 'locales', 'amplitude': amplitude, 's': s, 'nodes': 25 if quick else 50}
        for s in (1.0, 1.5, 2.0, 3.0)
        for amplitude in (5.0, 15.0, 50.0, 255.0, 1000.0, 4000.0)
    ]
    cases += [
        {'kind': 'snr', 'size': 9, 'sigma': 1.5, 'snr': snr, 'count': count, 'seed': 1}
        for snr in (5.0, 7.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0)
    ]
    cases += [
        {'kind': 'phase', 'size': 9, 'sigma': 1.2, 'snr': 100.0, 'phase': round(phase, 3),
         'count': count, 'seed': 2}
        for phase in np.linspace(-0.5, 0.5, 11 if quick else 41)
    ]
    cases += [
        {'kind': 'shape', 'shape': shape, 'size': 15, 'snr': 50.0, 'count': min(count, 10000),
         'seed': 3}
        for shape in SHAPES
    ]
    cases += [
        {'kind': 'speed', 'size': size, 'sigma': sigma, 'snr': 50.0, 'count': 2000,
         'repeats': 5 if quick else 15, 'seed': 4}
        for size, sigma in ((7, 1.2), (9, 1.5), (15, 2.5), (31, 5.0))
    ]
    return cases


def measure(case: Case) -> Measured:
    """Do one job."""
    return KINDS[case['kind']](case)


def _picture(case: Case) -> Measured:
    """Tell which displacements of a square have one rounded window, and so one locale."""
    places = np.linspace(-case['reach'], case['reach'], case['nodes'])
    profile = sampled_profile(9, 4.0 + places, case['s'] / np.sqrt(2.0))[0]
    windows = np.rint(
        case['amplitude'] * profile[:, None, :, None] * profile[None, :, None, :]
    ).astype(np.uint8).reshape(case['nodes'] ** 2, -1)
    _, number = np.unique(windows, axis=0, return_inverse=True)
    return {'number': number.ravel().tolist(), 'count': int(number.max()) + 1}


def _locales(case: Case) -> Measured:
    """Return the extent of the locales, and the errors of locators that do not know of them."""
    sigma, amplitude = case['s'] / np.sqrt(2.0), case['amplitude']
    # Half open, and not symmetric: mirrored places have mirrored windows.
    places = (np.arange(case['nodes']) + 0.37) / case['nodes'] - 0.5
    size = 9 if case['s'] < 2.5 else 15
    middle = (size - 1) / 2
    extent = locale_extent(
        (size, size), x=middle + places, y=middle + places, sigma=sigma, amplitude=amplitude
    )
    extent = extent[np.isfinite(extent)]
    profile = sampled_profile(size, middle + places, sigma)[0]
    lit = np.rint(amplitude * profile[:, None, :, None] * profile[None, :, None, :])
    truth = np.broadcast_to(places, (places.size, places.size)).ravel() + middle
    bound = cramer_rao_bound(
        (size, size), x=middle + 0.2, y=middle + 0.1, sigma=sigma, amplitude=amplitude,
        background=0.0, noise=ROUNDING, sampled=True,
    )
    measured: Measured = {
        'locale_rms': float(np.sqrt((extent**2).mean() / 12.0)),
        'locale_most': float(extent.max() / 2.0),
        'bound': float(np.sqrt(bound[0, 0])),
    }
    for method in METHODS:
        found = locate_batch(lit.reshape(-1, size, size), method=method, noise=ROUNDING)
        error = np.where(found.ok, found.x - truth, np.nan)
        measured[method] = {
            'rms': _number(np.sqrt(np.nanmean(error**2))) if found.ok.any() else None,
            'most': _number(np.nanmax(np.abs(error))) if found.ok.any() else None,
            'located': float(found.ok.mean()),
        }
    return measured


def _amplitude(snr: float) -> float:
    """Return the peak, DN, whose SNR in the camera's noise on the background is the one given."""
    floor = BACKGROUND_DN / CAMERA.gain + CAMERA.read_noise**2 + 1.0 / 12.0
    shot = snr**2 / CAMERA.gain
    return float(shot / 2.0 + np.sqrt(shot**2 / 4.0 + snr**2 * floor))


def _round_pulses(size: int, x: Pixels, y: Pixels, sigma: float) -> Pixels:
    """Return (N, size, size) unit pulses at places in the window."""
    down, across = (integrated_profile(size, place, sigma)[0] for place in (y, x))
    return down[:, :, None] * across[:, None, :]


def _errors(
    lit: NDArray[Any], x: Pixels, y: Pixels, saturation: float | None = None
) -> dict[str, dict[str, float | None]]:
    """Return rms and mean error, NEES and located part by method."""
    measured = {}
    for method in METHODS:
        found = locate_batch(lit, method=method, noise=CAMERA, saturation=saturation)
        errors = np.stack([found.x - x, found.y - y], axis=1)[found.ok]
        if not len(errors):
            measured[method] = {'located': 0.0, 'rms': None, 'bias': None, 'nees': None}
            continue
        squares = np.einsum(
            'ni,nij,nj->n', errors, np.linalg.inv(found.covariance[found.ok]), errors
        )
        measured[method] = {
            'located': float(found.ok.mean()),
            'rms': _number(np.sqrt((errors**2).mean())),
            'bias': _number(errors[:, 0].mean()),
            'nees': _number(squares.mean()),
        }
    return measured


def _noisy(case: Case) -> Measured:
    """Place pulses at one phase, or at all, and compare with the bound there."""
    size, sigma, count = case['size'], case['sigma'], case['count']
    random = np.random.default_rng(case['seed'])
    x, y = (size - 1) / 2 + random.uniform(-0.5, 0.5, (2, count))
    if 'phase' in case:
        x[:] = (size - 1) / 2 + case['phase']
    amplitude = _amplitude(case['snr'])
    lit = expose(
        amplitude * _round_pulses(size, x, y, sigma) + BACKGROUND_DN, CAMERA, random,
        saturation=65535,
    )
    bounds = [
        np.trace(cramer_rao_bound(
            (size, size), x=at_x, y=at_y, sigma=sigma, amplitude=amplitude,
            background=BACKGROUND_DN, noise=CAMERA,
        )) / 2.0
        for at_x, at_y in zip(x[:100], y[:100])
    ]
    return {**_errors(lit, x, y), 'bound': float(np.sqrt(np.mean(bounds)))}


def _shape(case: Case) -> Measured:
    """Place pulses of another shape than the table's."""
    size, count, shape = case['size'], case['count'], SHAPES[case['shape']]
    random = np.random.default_rng(case['seed'])
    offset = shape.get('offset', 0.0)
    x, y = (size - 1) / 2 + offset + random.uniform(-0.5, 0.5, (2, count))
    amplitude = _amplitude(case['snr'])
    if shape.get('three'):
        unit = amplitude / sum(LAMP_AMPLITUDES)
        light = np.sum([
            unit * peak * _round_pulses(size, x, y, s / np.sqrt(2.0))
            for peak, s in zip(LAMP_AMPLITUDES, LAMP_WIDTHS)
        ], axis=0)
    elif 'ratio' in shape:
        light = amplitude * _ellipses(size, x, y, shape['ratio'], shape.get('tilt', 0.0))
    else:
        light = amplitude * _round_pulses(size, x, y, shape.get('sigma', 1.5))
    full = 65535
    if 'clip' in shape:
        full = int(round(BACKGROUND_DN + shape['clip'] * amplitude))
    lit = expose(light + BACKGROUND_DN, CAMERA, random, saturation=full)
    return {**_errors(lit, x, y, float(full))}


def _ellipses(size: int, x: Pixels, y: Pixels, ratio: float, tilt: float) -> Pixels:
    """Return (N, size, size) elliptical pulses of sigma 1.5 px, sampled 3 x 3 in each pixel."""
    angle = np.deg2rad(tilt)
    wide, slim = 1.5 * np.sqrt(ratio), 1.5 / np.sqrt(ratio)
    fine = (np.arange(3 * size) - 1.0) / 3.0
    dx, dy = fine[None, None, :] - x[:, None, None], fine[None, :, None] - y[:, None, None]
    along = (np.cos(angle) * dx + np.sin(angle) * dy) / wide
    aside = (np.cos(angle) * dy - np.sin(angle) * dx) / slim
    light = np.exp(-0.5 * (along**2 + aside**2))
    means: Pixels = light.reshape(len(x), size, 3, size, 3).mean(axis=(2, 4))
    return means


def _speed(case: Case) -> Measured:
    """Return the fits a second of processor time, the methods taking turns."""
    random = np.random.default_rng(case['seed'])
    size, count = case['size'], case['count']
    x, y = (size - 1) / 2 + random.uniform(-0.5, 0.5, (2, count))
    pulses = _amplitude(case['snr']) * _round_pulses(size, x, y, case['sigma'])
    lit = expose(pulses + BACKGROUND_DN, CAMERA, random, saturation=65535).astype(float)
    seconds: dict[str, list[float]] = {method: [] for method in METHODS}
    single: dict[str, list[float]] = {method: [] for method in METHODS}
    window = Window(lit[0])
    for repeat in range(case['repeats'] + 1):
        for method in METHODS:
            start = process_time()
            locate_batch(lit, method=method, noise=CAMERA)
            batch = process_time() - start
            start = process_time()
            for _ in range(SINGLE_CALLS):
                locate(window, method=method, noise=CAMERA)
            if repeat:  # the first one compiles, and makes the tables
                seconds[method].append(batch)
                single[method].append((process_time() - start) / SINGLE_CALLS)
    rates = {method: count / median(taken) for method, taken in seconds.items()}
    return {**rates, 'single': {method: median(taken) for method, taken in single.items()}}


def _number(value: Any) -> float | None:
    """Return a number that JSON can hold."""
    return float(value) if np.isfinite(value) else None


KINDS: dict[str, Callable[[Case], Measured]] = {
    'picture': _picture, 'locales': _locales, 'snr': _noisy, 'phase': _noisy, 'shape': _shape,
    'speed': _speed,
}
