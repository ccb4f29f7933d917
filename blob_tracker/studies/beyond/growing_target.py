"""The thesis' future work: a target that is approached until its picture has grown tenfold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import math

from blob_tracker.location import locate
from blob_tracker.location.limits import cramer_rao_bound
from blob_tracker.segmentation import Segmenter
from blob_tracker.simulation.light import pixel_integrated_gaussian
from blob_tracker.simulation.noise_bank import NoiseBank
from blob_tracker.simulation.sensor import expose
from blob_tracker.studies.axes import COLOURS, legend_below, new_axes
from blob_tracker.studies.study import Case, Check, Findings, Measured, Study, Table
from blob_tracker.types import Frame, LocationError, SensorNoise, Window
from matplotlib.figure import Figure
import numpy as np
from numpy.typing import NDArray
import scipy  # which loads special, 20 MB, when it is first used

HEIGHT, WIDTH, RATE = 360, 480, 60.0  # px, px, frames/s
FULL = 255  # DN
NOISE = SensorNoise(gain=40.0, read_noise=0.7)
BACKGROUND = 20.0  # DN
OPTICS = 0.6  # px: sigma of the lens
FAR, NEAR = 0.53, 60.0  # px: sigma of the target's own picture, first and last
FRAMES = 400  # lit and unlit in turn: 1.2 % nearer in each
TENFOLD = 10.0
CONTROLLED = 0.6  # of full scale: where exposure control keeps the peak
FASTEST = 1.25  # factor of the exposure from one pair to the next, at most
EDGES = np.geomspace(0.8, 60.0, 11)  # px of sigma: what is counted together
LIGHTS = {
    'even exposure, peak to 180 DN': {'radiance': 180.0},
    'even exposure, peak to 4 x full scale': {'radiance': 1020.0},
    'exposure control': {'radiance': 1020.0, 'control': True},
    'even exposure, a disc': {'radiance': 180.0, 'disc': True},
}
MARKERS = 'osv^'
SIZE = 'sigma of the target in the picture, px'


@dataclass(frozen=True)
class _Target:
    """The target in one frame, px: place, width and its own part of it; its peak, DN."""

    x: float
    y: float
    sigma: float
    own: float
    peak: float


def _cases(quick: bool) -> Sequence[Case]:
    """Return one approach each."""
    return [
        {'light': light, 'seed': seed} for light in LIGHTS for seed in range(1 if quick else 8)
    ]


def _target(index: int, radiance: float) -> _Target:
    """
    Return the target in a frame.

    The range falls by the same part from frame to frame, so its own picture grows by it:
    sigma^2 = OPTICS^2 + own^2. A lamp's radiance does not change with its range; the lens
    spreads its light, and the peak is the radiance times own^2 / sigma^2. Far away that is the
    inverse square of the range, near by it is constant.
    """
    own = FAR * (NEAR / FAR) ** (index / (FRAMES - 1.0))
    sigma = math.hypot(OPTICS, own)
    # Slow enough for a following search, and with no period in common with the flash.
    turn = 2.0 * math.pi * index / 171.3
    return _Target(
        0.5 * WIDTH + 21.7 * math.sin(turn), 0.5 * HEIGHT + 16.3 * math.cos(1.31 * turn),
        sigma, own, radiance * own**2 / sigma**2,
    )


def _add_disc(picture: NDArray[np.float32], target: _Target, radiance: float) -> None:
    """
    Add an even disc, blurred by the lens and the pixel.

    A disc of radius 2 own has the variance own^2 along each axis. Through a Gaussian of sigma s
    it shows, at the distance r from its middle, the chance that a normal deviate about r falls
    within it: the non-central chi-square distribution of R^2 / s^2, two degrees, r^2 / s^2.
    """
    radius, blur = 2.0 * target.own, math.hypot(OPTICS, math.sqrt(1.0 / 12.0))
    rows, columns = np.ogrid[0:HEIGHT, 0:WIDTH]
    distance = np.hypot(columns - target.x, rows - target.y)
    picture[distance <= radius - 6.0 * blur] += radiance
    edge = np.abs(distance - radius) < 6.0 * blur
    picture[edge] += radiance * scipy.special.chndtr(
        (radius / blur) ** 2, 2.0, (distance[edge] / blur) ** 2
    )


def _measure(case: Case) -> Measured:
    """Approach once; return what the default pipeline makes of each lit frame."""
    light = LIGHTS[case['light']]
    segmenter = Segmenter()
    exposure = 1.0
    if light.get('control'):
        exposure = CONTROLLED * FULL / _target(0, light['radiance']).peak
    seen: list[Measured] = []
    for index in range(FRAMES):
        target = _target(index, light['radiance'])
        lit = index % 2 == 0
        picture = np.full((HEIGHT, WIDTH), BACKGROUND * exposure, dtype=np.float32)
        if lit and light.get('disc'):
            _add_disc(picture, target, exposure * light['radiance'])
        elif lit:
            picture += exposure * target.peak * pixel_integrated_gaussian(
                picture.shape, target.x, target.y, target.sigma
            ).astype(np.float32)
        pixels = expose(picture, NOISE, NoiseBank(case['seed'], index), saturation=FULL)
        window = segmenter.update(Frame(pixels, round(1e9 * (1 + index / RATE)), FULL))
        if lit:
            seen.append(_seen(target, exposure, window, segmenter.reason, light))
        elif light.get('control') and seen[-1]['brightest']:
            # From pair to pair: within one it would show as a change of the whole picture.
            wanted = CONTROLLED * FULL / seen[-1]['brightest']
            exposure *= min(max(wanted, 1.0 / FASTEST), FASTEST)
    return {'seen': seen}


def _seen(
    target: _Target, exposure: float, window: Window | None, reason: str, light: dict[str, float]
) -> Measured:
    """Return one lit frame's window and error, with the bound there."""
    one: Measured = {
        'sigma': target.sigma, 'peak': exposure * target.peak, 'reason': reason,
        'brightest': None, 'half': None, 'error': None, 'covariance': None, 'bound': None,
    }
    if window is None:
        return one
    height, width = window.lit.shape
    one['half'] = max(height, width) // 2
    one['brightest'] = float(window.lit.max())
    try:
        found = locate(window, noise=NOISE)
    except LocationError as error:
        one['reason'] = str(error)
        return one
    one['error'] = [found.x - target.x, found.y - target.y]
    one['covariance'] = found.covariance.tolist()
    if not light.get('disc'):
        bound = cramer_rao_bound(
            (height, width), x=target.x - window.x0, y=target.y - window.y0, sigma=target.sigma,
            amplitude=exposure * target.peak, background=BACKGROUND * exposure, noise=NOISE,
            saturation=FULL,
        )
        one['bound'] = [float(bound[0, 0]), float(bound[1, 1])]
    return one


def _conclude(results: Sequence[tuple[Case, Measured]]) -> Findings:
    """Put the approaches under one light together, by the size of the target."""
    rows: list[list[float | str | None]] = []
    ends: list[list[float | str | None]] = []
    for light in LIGHTS:
        approaches = [found['seen'] for case, found in results if case['light'] == light]
        rows += [_row(light, low, high, approaches) for low, high in zip(EDGES, EDGES[1:])]
        ends.append(_end(light, approaches))
    plain = [row for row in rows if row[0] == next(iter(LIGHTS)) and row[5] is not None]
    kept = {str(end[0]): float(end[1] or 0.0) for end in ends}
    grown = {str(end[0]): float(end[3] or 0.0) for end in ends}
    over = [float(row[6] or 0.0) for row in plain]
    first = next(iter(LIGHTS))
    disc = [row for row in rows if row[0] == list(LIGHTS)[-1] and row[8] is not None]
    careful = min(float(row[8] or 0.0) for row in disc)
    furthest = max(float(row[5] or 0.0) for row in disc)
    shows = (
        f'The default pipeline follows the target from sigma 0.8 px to {ends[0][2]:.0f} px, '
        f'{grown[first]:.0f} times its first size, with {100.0 * kept[first]:.1f} % of the '
        f'flashes placed from the first lock to the end, and its rms error stays within '
        f'{min(over):.2f} to {max(over):.2f} times the Cramer-Rao bound of its windows. It ends '
        f'because: {ends[0][4]}. The bound hardly changes on the way: a lamp of one radiance '
        'that is twice as wide gives four times the light. An even disc is no Gaussian: it is '
        f'placed to {furthest:.4f} px, but its covariance, which grows with the misfit, is much '
        f'too large (NEES down to {careful:.3f} of 2), and it is refused as no blob from '
        f'sigma {ends[-1][2]:.0f} px on ({ends[-1][4]}).'
    )
    checks = [
        Check(f'{end[0]}: followed', 'tenfold, every flash placed until then',
              f'{100.0 * float(end[5] or 0.0):.1f} % until then; {grown[str(end[0])]:.0f}-fold in '
              f'all, {100.0 * kept[str(end[0])]:.1f} %',
              grown[str(end[0])] >= TENFOLD and end[5] == 1.0)
        for end in ends
    ]
    checks.append(Check(
        f'{first}: rms error over the bound, all sizes', '<= 1.3',
        f'{min(over):.2f} to {max(over):.2f}', max(over) <= 1.3,
    ))
    return Findings(
        shows=shows,
        agreement=(
            f'followed until it has grown {grown[first]:.0f}-fold, to {max(over):.2f} times the '
            'Cramer-Rao bound at most; a disc '
            f'{grown[list(LIGHTS)[-1]]:.0f}-fold'
        ),
        tables=(
            Table(
                'growing_target', 'Along the approach, by the size of the target',
                ('light', 'sigma from, px', 'to, px', 'placed of flashes', 'window half, px',
                 'rms error, px', 'over the bound', 'bound, px', 'NEES of 2',
                 'sampling error of rms'),
                rows,
            ),
            Table(
                'growing_target_ends', 'How far it is followed',
                ('light', 'placed from lock to end', 'last sigma, px', 'grown, times',
                 'why it ends', 'placed from lock to tenfold'),
                ends,
            ),
        ),
        figures={
            'growing_target_error': _draw_errors(rows),
            'growing_target_window': _draw_windows(results),
        },
        checks=checks,
    )


def _row(
    light: str, low: float, high: float, approaches: Sequence[Sequence[Measured]]
) -> list[float | str | None]:
    """Return the table's row of one range of sizes."""
    flashes = [one for seen in approaches for one in seen if low <= one['sigma'] < high]
    placed = [one for one in flashes if one['error'] is not None]
    row: list[float | str | None] = [light, round(low, 2), round(high, 2)]
    row.append(len(placed) / max(len(flashes), 1))
    if not placed:
        return [*row, None, None, None, None, None, None]
    errors = np.array([one['error'] for one in placed])
    covariance = np.array([one['covariance'] for one in placed])
    nees = np.einsum('ni,nij,nj->n', errors, np.linalg.inv(covariance), errors).mean()
    over = bound = None
    if placed[0]['bound'] is not None:
        bounds = np.array([one['bound'] for one in placed])
        # Each error over its own bound: along one row of sizes that changes twofold.
        over = float(np.sqrt((errors**2 / bounds).mean()))
        bound = float(np.sqrt(bounds.mean()))
    half = float(np.median([one['half'] for one in placed]))
    # Of an rms of n normal errors, relative to it.
    sampling = float(1.0 / np.sqrt(2.0 * errors.size))
    return [*row, half, float(np.sqrt((errors**2).mean())), over, bound, float(nees), sampling]


def _end(light: str, approaches: Sequence[Sequence[Measured]]) -> list[float | str | None]:
    """Return how far the target was followed: the least of all approaches, and why it ended."""
    last = [max(k for k, one in enumerate(seen) if one['error']) for seen in approaches]
    first = [min(k for k, one in enumerate(seen) if one['error']) for seen in approaches]
    placed = [
        sum(one['error'] is not None for one in seen[begin:end + 1]) / (end + 1 - begin)
        for seen, begin, end in zip(approaches, first, last)
    ]
    worst = int(np.argmin(last))
    seen, end = approaches[worst], last[worst]
    why = seen[end + 1]['reason'] if end + 1 < len(seen) else 'the approach is over'
    tenfold = [
        [one['error'] is not None for one in each[begin:]
         if one['sigma'] <= TENFOLD * each[0]['sigma']]
        for each, begin in zip(approaches, first)
    ]
    return [
        light, min(placed), seen[end]['sigma'], seen[end]['sigma'] / seen[0]['sigma'], why,
        min(sum(each) / len(each) for each in tenfold),
    ]


def _draw_errors(rows: Sequence[Sequence[float | str | None]]) -> Figure:
    figure, (left, right) = new_axes(2)
    left.set(xlabel=SIZE, ylabel='rms error, px', xscale='log', yscale='log')
    right.set(xlabel=SIZE, ylabel='rms error / bound', xscale='log')
    for light, colour, marker in zip(LIGHTS, COLOURS, MARKERS):
        own = np.array(
            [[np.nan if cell is None else cell for cell in row[1:]] for row in rows
             if row[0] == light], dtype=float,
        )
        size = np.sqrt(own[:, 0] * own[:, 1])
        left.plot(size, own[:, 4], marker + '-', color=colour, label=light)
        left.plot(size, own[:, 6], '--', color=colour)
        right.plot(size, own[:, 5], marker + '-', color=colour)
    left.plot([], [], 'k--', label='Cramer-Rao bound of the window')
    right.axhline(1.0, linestyle='--', color='black')
    right.set_ylim(bottom=0.0)
    legend_below(figure, left, 3)
    return figure


def _draw_windows(results: Sequence[tuple[Case, Measured]]) -> Figure:
    figure, (left, right) = new_axes(2)
    left.set(xlabel=SIZE, ylabel='half the window, px', xscale='log', yscale='log')
    right.set(xlabel=SIZE, ylabel='peak of the target, DN', xscale='log', yscale='log')
    # Those below show around those above where the two fall together.
    for light, colour, marker, area in zip(LIGHTS, COLOURS, MARKERS, (8, 3, 4, 3)):
        seen = next(found['seen'] for case, found in results if case['light'] == light)
        own = [one['sigma'] for one in seen]
        left.plot(own, [one['half'] or np.nan for one in seen], marker, color=colour,
                  markersize=area, label=light)
        right.plot(own, [one['peak'] for one in seen], color=colour, linewidth=area / 2)
    sizes = np.geomspace(0.8, NEAR, 50)
    left.plot(sizes, 3.0 * sizes, 'k--', label='3 sigma')
    left.axhline(128.0, linestyle=':', color='black', label='max_blob')
    right.axhline(FULL, linestyle=':', color='black', label='full scale')
    right.legend(fontsize='small')
    legend_below(figure, left, 3)
    return figure


STUDY = Study(
    name='growing_target',
    title='A target that grows tenfold, and on, while it is approached',
    source='Section 6.1, page 119',
    cases=_cases,
    measure=_measure,
    conclude=_conclude,
)
