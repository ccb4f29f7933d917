"""The thesis' future work: locales as a table, its accuracy and its speed beside the others."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from statistics import median
from time import process_time
from typing import Any

from blob_tracker.location import locate, locate_batch
from blob_tracker.location.limits import cramer_rao_bound, locale_extent
from blob_tracker.location.multi_gaussian import LAMP_AMPLITUDES, LAMP_WIDTHS
from blob_tracker.location.pulse import integrated_profile, sampled_profile
from blob_tracker.simulation.sensor import expose
from blob_tracker.studies.axes import COLOURS as OKABE_ITO, GOAL, new_axes
from blob_tracker.studies.study import Case, Check, Findings, Measured, Study, Table
from blob_tracker.types import SensorNoise, Window
from matplotlib.figure import Figure
import numpy as np
from numpy.typing import NDArray

METHODS = ('centroid', 'centroid_skew_corrected', 'locale_table', 'maximum_likelihood')
COLOURS = dict(zip((*METHODS, 'locales', 'bound'),
                   (OKABE_ITO[k] for k in (5, 3, 0, 2, 1, 6))))
MARKERS = dict(zip(METHODS, 'ovs^'))
ROUNDING = SensorNoise(gain=1e9, read_noise=0.0)  # 1/12 DN^2 and nothing else
CAMERA = SensorNoise(gain=20.0, read_noise=0.25)
BACKGROUND = 20.0  # DN
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

Pixels = NDArray[np.float64]


def _cases(quick: bool) -> Sequence[Case]:
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


def _measure(case: Case) -> Measured:
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
    floor = BACKGROUND / CAMERA.gain + CAMERA.read_noise**2 + 1.0 / 12.0
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
        amplitude * _round_pulses(size, x, y, sigma) + BACKGROUND, CAMERA, random,
        saturation=65535,
    )
    bounds = [
        np.trace(cramer_rao_bound(
            (size, size), x=at_x, y=at_y, sigma=sigma, amplitude=amplitude,
            background=BACKGROUND, noise=CAMERA,
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
        full = int(round(BACKGROUND + shape['clip'] * amplitude))
    lit = expose(light + BACKGROUND, CAMERA, random, saturation=full)
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
    lit = expose(pulses + BACKGROUND, CAMERA, random, saturation=65535).astype(float)
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


def _conclude(results: Sequence[tuple[Case, Measured]]) -> Findings:
    """Draw and judge."""
    by_kind = {
        kind: [(case, found) for case, found in results if case['kind'] == kind]
        for kind in KINDS
    }
    locales, snr, phase = by_kind['locales'], by_kind['snr'], by_kind['phase']
    thesis = next(
        found for case, found in locales if (case['s'], case['amplitude']) == (1.0, 255.0)
    )
    sure = [found for case, found in snr if case['snr'] >= 10.0]
    ratio = max(found['locale_table']['rms'] / found['bound'] for found in sure)
    nees = [found['locale_table']['nees'] for found in sure]
    bias = max(abs(found['locale_table']['bias']) for _, found in phase)
    faster = {}
    for method in METHODS:
        ratios = [found['locale_table'] / found[method] for _, found in by_kind['speed']]
        faster[method] = f'{min(ratios):.1f} to {max(ratios):.1f} times'
    single = by_kind['speed'][0][1]['single']
    # Of a node that places one window in each frame.
    saved = 1e6 * (single['maximum_likelihood'] - single['locale_table'])
    shapes = {case['shape']: found for case, found in by_kind['shape']}
    tilted = shapes['ellipse, axes 1.5 to 1, at 45 degrees']
    tilted = tilted['locale_table']['rms'] / tilted['maximum_likelihood']['rms']
    clipped = shapes['Gaussian, clipped at half its peak']['locale_table']['located']
    shows = (
        f"The locales of the thesis' pulse (A 255 DN, s 1 px) leave {thesis['locale_rms']:.4f} px "
        f'rms and {thesis["locale_most"]:.4f} px at most to a map that knows its amplitude and '
        f'width, which is below what rounding leaves to anybody else ({thesis["bound"]:.4f} px). '
        'A table of normalised ratios, which needs to know neither, stays within '
        f'{ratio:.2f} times the Cramer-Rao bound from SNR 10 to 500, at '
        f'{faster["maximum_likelihood"]} the fits a second of maximum likelihood and '
        f'{faster["centroid"]} those of the centroid, in stacks of windows. A single call saves '
        f'{saved:.0f} of {1e6 * single["maximum_likelihood"]:.0f} us: the rest is the call '
        f'itself. With tilted blobs its rms error is {tilted:.1f} times that of maximum '
        f'likelihood, and of clipped ones it places {100.0 * clipped:.0f} %.'
    )
    return Findings(
        shows=shows,
        agreement=(
            f'a table is within {ratio:.2f} times the Cramer-Rao bound, at '
            f'{faster["maximum_likelihood"]} the fits a second of maximum likelihood'
        ),
        tables=(
            _locale_rows(locales),
            _error_rows('locale_table_snr', 'rms error over peak SNR; 9 x 9, sigma 1.5 px',
                        'peak SNR', snr, 'snr'),
            _error_rows('locale_table_phase',
                        'error over sub-pixel phase; 9 x 9, sigma 1.2 px, SNR 100',
                        'phase, px', phase, 'phase'),
            _shape_rows(by_kind['shape']),
            _speed_rows(by_kind['speed']),
        ),
        figures={
            'locale_table_locales': _draw_pictures(by_kind['picture']),
            'locale_table_sizes': _draw_sizes(locales),
            'locale_table_snr': _draw_snr(snr),
            'locale_table_phase': _draw_phase(phase),
        },
        checks=(
            Check('rms error of locale_table from SNR 10 to 500', '<= 1.05 x the bound',
                  f'{ratio:.3f} x', ratio <= 1.05),
            Check('its covariance from SNR 10 to 500', 'NEES 1.9 to 2.1 of 2',
                  f'{min(nees):.2f} to {max(nees):.2f}', 1.9 <= min(nees) and max(nees) <= 2.1),
            Check('its bias over the sub-pixel phase', '<= 0.005 px', f'{bias:.4f} px',
                  bias <= 0.005),
            Check("the locales of the thesis' pulse", f'<= {GOAL:g} px',
                  f'{thesis["locale_most"]:.4f} px at most', thesis['locale_most'] <= GOAL),
        ),
    )


def _locale_rows(locales: Iterable[tuple[Case, Measured]]) -> Table:
    return Table(
        'locale_table_sizes',
        "Locales of the thesis' sampled pulse, rounded, and locators that do not know of them",
        ('s, px', 'A, DN', 'exact map rms, px', 'exact map most, px', 'bound of 1/12 DN^2, px',
         *(f'{method} {what}, px' for method in METHODS for what in ('rms', 'most'))),
        [
            (case['s'], case['amplitude'], found['locale_rms'], found['locale_most'],
             found['bound'], *(found[method][what] for method in METHODS
                               for what in ('rms', 'most')))
            for case, found in locales
        ],
    )


def _error_rows(
    name: str, title: str, heading: str, results: Iterable[tuple[Case, Measured]], key: str
) -> Table:
    kinds = ('rms', 'bias', 'nees', 'located')
    units = {'rms': 'rms, px', 'bias': 'mean in x, px', 'nees': 'NEES', 'located': 'located'}
    return Table(
        name, title,
        (heading, 'bound, px', *(f'{method} {units[kind]}' for method in METHODS
                                 for kind in kinds)),
        [
            (case[key], found['bound'], *(found[method][kind] for method in METHODS
                                          for kind in kinds))
            for case, found in results
        ],
    )


def _shape_rows(shapes: Iterable[tuple[Case, Measured]]) -> Table:
    return Table(
        'locale_table_shapes', 'Where it loses: rms error by shape; 15 x 15, SNR 50',
        ('shape', *(f'{method} {what}' for method in METHODS
                    for what in ('rms, px', 'NEES', 'located'))),
        [
            (case['shape'], *(found[method][what] for method in METHODS
                              for what in ('rms', 'nees', 'located')))
            for case, found in shapes
        ],
    )


def _speed_rows(speeds: Iterable[tuple[Case, Measured]]) -> Table:
    others = [method for method in METHODS if method != 'locale_table']
    return Table(
        'locale_table_speed',
        'Fits a second of one core, and locale_table over the others in the same run',
        ('window, px', 'sigma, px', *(f'{method}, 1/s' for method in METHODS),
         *(f'over {method}' for method in others),
         *(f'one call of {method}, us' for method in METHODS)),
        [
            (case['size'], case['sigma'], *(round(found[method]) for method in METHODS),
             *(round(found['locale_table'] / found[method], 2) for method in others),
             *(round(1e6 * found['single'][method], 1) for method in METHODS))
            for case, found in speeds
        ],
    )


def _draw_pictures(pictures: Sequence[tuple[Case, Measured]]) -> Figure:
    """Colour displacements by their locale: neighbours of one colour give one picture."""
    figure, panels = new_axes(len(pictures))
    for axes, (case, found) in zip(panels, pictures):
        axes.set(xlabel='displacement in x, px', ylabel='displacement in y, px')
        axes.grid(False)
        axes.locator_params(nbins=5)
        nodes, reach = case['nodes'], case['reach']
        # Numbers of neighbours are near one another: shuffled, so that their colours are not.
        shuffled = np.random.default_rng(0).permutation(found['count'])
        axes.imshow(
            shuffled[np.array(found['number'])].reshape(nodes, nodes), origin='lower',
            extent=(-reach, reach, -reach, reach), cmap='cividis', interpolation='nearest',
        )
        axes.set_title(
            f"A {case['amplitude']:g} DN, s {case['s']:g} px: {found['count']} locales\n"
            f'in {2 * reach:g} x {2 * reach:g} px', fontsize=10,
        )
    return figure


def _draw_sizes(locales: Sequence[tuple[Case, Measured]]) -> Figure:
    figure, (axes, right) = new_axes(2)
    axes.set(xlabel='amplitude A, DN', ylabel='rms error in x, px')
    rows = [(case, found) for case, found in locales if case['s'] == 1.5]
    amplitudes = [case['amplitude'] for case, _ in rows]
    axes.loglog(amplitudes, [found['locale_rms'] for _, found in rows], 'D-',
                color=COLOURS['locales'], label='exact map of the locales')
    for method in METHODS:
        axes.loglog(amplitudes, [found[method]['rms'] or np.nan for _, found in rows],
                    MARKERS[method] + '-', color=COLOURS[method], label=method)
    axes.loglog(amplitudes, [found['bound'] for _, found in rows], '--', color=COLOURS['bound'],
                label='bound, variance 1/12')
    axes.set_title(
        's 1.5 px, no noise but the rounding;\nonly the exact map is told A and s', fontsize=10
    )
    axes.legend(fontsize=8)
    right.set(xlabel='amplitude A, DN', ylabel='half the extent of a locale in x, px')
    styles = zip(('o-', 'v-', 's-', '^-'), COLOURS.values(), (1.0, 1.5, 2.0, 3.0))
    for style, colour, s in styles:
        own = [(case['amplitude'], found) for case, found in locales if case['s'] == s]
        right.loglog(
            [amplitude for amplitude, _ in own], [found['locale_most'] for _, found in own],
            style, color=colour, label=f's {s:g} px',
        )
        right.loglog([amplitude for amplitude, _ in own],
                     [found['locale_rms'] * np.sqrt(3.0) for _, found in own], ':',
                     color=colour)
    right.set_title('widest locale (solid)\nand rms over places (dotted)', fontsize=10)
    right.legend(fontsize=8)
    return figure


def _draw_snr(results: Sequence[tuple[Case, Measured]]) -> Figure:
    figure, (left, right) = new_axes(2)
    snr = [case['snr'] for case, _ in results]
    left.set(xlabel='peak SNR', ylabel='rms error, px')
    right.set(xlabel='peak SNR', ylabel='rms error / Cramer-Rao bound')
    for method in METHODS:
        rms = [found[method]['rms'] or np.nan for _, found in results]
        over = [each / found['bound'] for each, (_, found) in zip(rms, results)]
        left.loglog(snr, rms, MARKERS[method] + '-', color=COLOURS[method], label=method)
        right.semilogx(snr, over, MARKERS[method] + '-', color=COLOURS[method])
    left.loglog(snr, [found['bound'] for _, found in results], '--', color=COLOURS['bound'],
                label='Cramer-Rao bound')
    right.axhline(1.0, linestyle='--', color=COLOURS['bound'])
    left.legend(fontsize=8)
    return figure


def _draw_phase(results: Sequence[tuple[Case, Measured]]) -> Figure:
    figure, (left, right) = new_axes(2)
    phase = [case['phase'] for case, _ in results]
    left.set(xlabel='sub-pixel phase in x, px', ylabel='mean error in x, px')
    right.set(xlabel='sub-pixel phase in x, px', ylabel='rms error, px')
    for method in METHODS:
        style = MARKERS[method] + '-'
        left.plot(phase, [found[method]['bias'] for _, found in results], style,
                  color=COLOURS[method], markersize=4)
        right.plot(phase, [found[method]['rms'] for _, found in results], style,
                   color=COLOURS[method], markersize=4, label=method)
    right.plot(phase, [found['bound'] for _, found in results], '--', color=COLOURS['bound'],
               label='Cramer-Rao bound')
    right.set_ylim(bottom=0.0)
    right.legend(fontsize=8)
    return figure


STUDY = Study(
    name='locale_table',
    title='Locales as a look-up: what a table of them can do, and how fast',
    source='Sections 2.3 and 6.1, pages 21 and 118',
    cases=_cases,
    measure=_measure,
    conclude=_conclude,
)
