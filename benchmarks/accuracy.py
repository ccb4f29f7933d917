"""Root-mean-square error over the Cramer-Rao bound, and bias against sub-pixel phase."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from benchmarks.contender import Contender, count_for, inside
from benchmarks.ours import CHAMPION, texture_references
from benchmarks.scenes import Sample, sample, Scene
from benchmarks.windows import take
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

Tick = Callable[[str], None]

# The three scenes on which others were measured. Their sigma, background and read noise are
# given where the name does not: 9 x 9 at sigma 1.5; 10 e-, 40 e- and 40 e- of background.
NAMED = {
    '7x7, sigma 1.3, N 1000': (7, 1.3, 1000.0, SensorNoise(1.0, 0.0), 10.0),
    '9x9, N 5000, read 2, gain 8': (9, 1.5, 5000.0, SensorNoise(8.0, 2.0 / 8.0), 5.0),
    '15x15, sigma 2.5, N 20000, gain 40': (15, 2.5, 20000.0, SensorNoise(40.0, 0.0), 1.0),
}
TARGET = 'target'  # the sweep over windows and SNR that the targets name
PHASES = 21
PHASE_SCENES = {
    'sigma 0.6, 7x7': Scene(7, 0.6, 200.0),
    'sigma 1.3, 9x9': Scene(9, 1.3, 200.0),
    'sigma 2.5, 15x15': Scene(15, 2.5, 200.0),
}


@dataclass(frozen=True)
class Row:
    """
    One contender on one scene.

    Parameters
    ----------
    sweep, value : str
        What is varied and where it stands.
    contender : str
        Name.
    rms : float
        Root mean square error of x and y together, px.
    ratio : float
        rms over the bound.
    spread : float
        Standard error of the ratio, from the count alone.
    failed : float
        Share of the windows without an answer inside the window; left out of the rms.
    count : int
        How many windows.
    nees : float or None
        Mean of e^T Cov^-1 e on the target's scenes, 2 where the stated covariance is true.
    champion : float
        rms of maximum_likelihood over the contender's, on the windows that both have located.
    champion_spread : float
        Standard error of its logarithm; small where both err alike on the same windows.

    """

    sweep: str
    value: str
    contender: str
    rms: float
    ratio: float
    spread: float
    failed: float
    count: int
    nees: float | None
    champion: float
    champion_spread: float


@dataclass(frozen=True)
class Bias:
    """
    Mean error of one contender along x against the sub-pixel phase, px.

    Parameters
    ----------
    scene, contender : str
        Names.
    phase, mean, spread : list
        True x less the middle of its pixel; mean error; its standard error; px.

    """

    scene: str
    contender: str
    phase: list[float]
    mean: list[float]
    spread: list[float]


def sweeps() -> dict[str, dict[str, Scene]]:
    """Return the scenes: sweep -> value -> scene."""
    return {
        'scene': {name: _named(*values) for name, values in NAMED.items()},
        'snr': {str(snr): Scene(9, 1.5, snr) for snr in (3, 5, 10, 20, 50, 100, 200)},
        'window': {str(side): Scene(side, 1.3, 50.0) for side in (5, 7, 9, 11, 15, 19, 25)},
        'sigma': {
            str(sigma): Scene(_side(sigma), sigma, 50.0)
            for sigma in (0.6, 0.8, 1.0, 1.5, 2.0, 3.0, 5.0, 8.0)
        },
        'axis ratio': {
            str(ratio): Scene(13, 1.8, 50.0, axis_ratio=ratio) for ratio in (1.0, 1.2, 1.5, 2.0)
        },
        'texture': {
            str(texture): Scene(11, 1.5, 50.0, background=100.0, texture=texture)
            for texture in (0.0, 0.01, 0.02, 0.05, 0.1, 0.3)
        },
        'saturation': {
            str(over): Scene(15, 2.0, 100.0, overexposure=over)
            for over in (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)
        },
    }


def target_scenes() -> dict[str, Scene]:
    """Return windows 7 to 15 px at peak SNR 10 to 200, three sigma to either side."""
    return {
        f'{side}x{side}, snr {snr}': Scene(side, side / 6, snr)
        for side in (7, 9, 11, 15)
        for snr in (10, 20, 50, 100, 200)
    }


def run(contenders: Sequence[Contender], count: int, tick: Tick) -> list[Row]:
    """
    Return the rows of all sweeps and of the target's scenes.

    Every contender gets the same windows, the slow ones the first of them.
    """
    rows: list[Row] = []
    for sweep, scenes in {**sweeps(), TARGET: target_scenes()}.items():
        field = [*contenders, *texture_references()] if sweep == 'texture' else contenders
        for seed, (value, scene) in enumerate(scenes.items()):
            tick(f'{sweep} {value}')
            rows += measure(sweep, value, sample(scene, count, seed), field)
    return rows


def measure(sweep: str, value: str, seen: Sample, contenders: Sequence[Contender]) -> list[Row]:
    """Return a row for each contender on one scene."""
    best = next(each for each in contenders if each.name == CHAMPION)
    champion = _errors(seen, best, len(seen.x))
    return [_row(sweep, value, seen, contender, champion) for contender in contenders]


def run_bias(contenders: Sequence[Contender], count: int, tick: Tick) -> list[Bias]:
    """Return the bias of each contender at PHASES phases, from `count` windows a phase."""
    phases = np.linspace(-0.5, 0.5, PHASES)
    found: list[Bias] = []
    for seed, (name, scene) in enumerate(PHASE_SCENES.items()):
        tick(f'bias {name}')
        places = np.stack([phases, np.random.default_rng(seed).permutation(phases)], axis=1)
        seen = sample(scene, count * PHASES, seed, places)
        found += [_bias(name, phases, seen, contender) for contender in contenders]
    return found


def steps() -> int:
    """Return how many ticks `run` and `run_bias` make."""
    return sum(map(len, sweeps().values())) + len(target_scenes()) + len(PHASE_SCENES)


def _named(
    window: int, sigma: float, electrons: float, noise: SensorNoise, background: float
) -> Scene:
    """Return the scene with N electrons in the pulse: A = N / (2 pi sigma^2 gain)."""
    level = electrons / (2 * np.pi * sigma**2 * noise.gain)
    variance = (level + background) / noise.gain + noise.read_noise**2 + 1 / 12
    return Scene(window, sigma, float(level / np.sqrt(variance)), noise, background)


def _side(sigma: float) -> int:
    """Return the odd window that holds three sigma to either side, 7 to 25 px."""
    return int(np.clip(2 * round(3 * sigma) + 1, 7, 25))


def _errors(seen: Sample, contender: Contender, count: int) -> NDArray[np.float64]:
    """Return (count, 2) px: located less true, NaN where nothing was found."""
    windows = take(seen.windows, count)
    x, y = inside(contender.locate(windows), windows.lit.shape[1:])
    return np.stack([x - seen.x[:count], y - seen.y[:count]], axis=1)


def _row(
    sweep: str,
    value: str,
    seen: Sample,
    contender: Contender,
    champion: NDArray[np.float64],
) -> Row:
    count = count_for(contender, len(seen.x))
    errors = _errors(seen, contender, count)
    good = np.isfinite(errors).all(axis=1)
    squares = (errors[good] ** 2).mean(axis=1)
    rms = float(np.sqrt(squares.mean())) if good.any() else float('nan')
    both = good & np.isfinite(champion[:count]).all(axis=1)
    ahead, ahead_spread = compare(champion[:count][both], errors[both])
    stated = None
    if sweep == TARGET and contender.covariance is not None and good.any():
        covariance = contender.covariance(take(seen.windows, count))
        stated = nees(errors[good], covariance[good])
    return Row(
        sweep=sweep,
        value=value,
        contender=contender.name,
        rms=rms,
        ratio=rms / seen.bound,
        # d rms = d mean / (2 rms)
        spread=float(squares.std() / np.sqrt(max(good.sum(), 1)) / (2 * rms) / seen.bound),
        failed=float(1 - good.mean()),
        count=count,
        nees=stated,
        champion=ahead,
        champion_spread=ahead_spread,
    )


def compare(
    ours: NDArray[np.float64], theirs: NDArray[np.float64]
) -> tuple[float, float]:
    """
    Return the ratio of the rms of two methods' (N, 2) errors and the standard error of its log.

    With the squared errors a and b of the two on one window, by the delta method,

        d ln(rms ratio) = (a / mean a - b / mean b) / 2N

    summed over the windows: what noise has done to both alike drops out.
    """
    if not len(ours):
        return float('nan'), float('nan')
    a, b = (ours**2).sum(axis=1), (theirs**2).sum(axis=1)
    spread = (a / a.mean() - b / b.mean()).std() / (2 * np.sqrt(len(a)))
    return float(np.sqrt(a.mean() / b.mean())), float(spread)


def nees(errors: NDArray[np.float64], covariance: NDArray[np.float64]) -> float:
    """Return the mean of e^T Cov^-1 e."""
    return float(np.einsum('ni,nij,nj->n', errors, np.linalg.inv(covariance), errors).mean())


def _bias(name: str, phases: NDArray[np.float64], seen: Sample, contender: Contender) -> Bias:
    rounds = max(2, count_for(contender, len(seen.x)) // len(phases))
    errors = _errors(seen, contender, rounds * len(phases))[:, 0].reshape(-1, len(phases))
    found = np.isfinite(errors).sum(axis=0)
    with np.errstate(invalid='ignore', divide='ignore'):  # a phase without an answer has no mean
        mean = np.nansum(errors, axis=0) / found
        spread = np.sqrt(np.nansum((errors - mean) ** 2, axis=0)) / found
    return Bias(name, contender.name, phases.tolist(), mean.tolist(), spread.tolist())
