"""Which defect of the experiment of chapter 5 turns 0.05 px into the thesis' 0.25 px."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
import math

from blob_tracker.camera.trailing_edge import TrailingEdge
from blob_tracker.simulation.analogue_chain import AnalogueChain
from blob_tracker.simulation.trailing_edge import MEMORY_PX, PEAKING
from blob_tracker.studies.beyond.causes_pictures import draw_causes, draw_sizes
from blob_tracker.studies.beyond.causes_printed import implied, ratio_of_looks, results_here
from blob_tracker.studies.chapter_5.displacements import (
    bound, Conditions, draw, figures_of, LABORATORY, NOISE, placed, TARGETS,
)
from blob_tracker.studies.printed import load
from blob_tracker.studies.study import Case, Cell, Check, Findings, Measured, Study, Table
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

STEP = '0.05'
SEEDS = (2, 60)  # quick and full
TOGETHER = 4
SILENT = SensorNoise(np.inf, 0.0)
ROUNDED = Conditions(noise=SILENT)

# What is in the text, at the size that the text or its sources give, each alone on rounded pixels.
CAUSES: dict[str, Conditions] = {
    'nothing': Conditions(noise=None),
    'rounding to 8 bit': ROUNDED,
    'noise 1 DN': Conditions(),
    'noise 3 DN': Conditions(noise=SensorNoise(np.inf, 3.0)),
    'line drift, 0.25 px over a field': replace(ROUNDED, chain=AnalogueChain(drift=1.0)),
    'second field off by 0.02 px': replace(ROUNDED, chain=AnalogueChain(between_fields=0.02)),
    'jitter of each line, 1/20 px': replace(ROUNDED, chain=AnalogueChain(per_line=0.05)),
    'jitter of each frame, 1/20 px': replace(ROUNDED, chain=AnalogueChain(per_frame=0.05)),
    'trailing edge': replace(
        ROUNDED, chain=AnalogueChain(trailing_edge=TrailingEdge(PEAKING, MEMORY_PX))
    ),
    '641 cells on 640 pixels': replace(ROUNDED, chain=AnalogueChain(own_clock=True)),
    'caliper, 1/1000 inch': replace(ROUNDED, caliper=0.001),
    'all of them, noise 1 DN': LABORATORY,
    'all, jitter of each frame too': replace(
        LABORATORY, chain=replace(LABORATORY.chain, per_frame=0.05)
    ),
    'all, and the camera turns by 0.1 mrad': replace(LABORATORY, turn=0.1),
}
TOGETHER_ALL = 'all of them, noise 1 DN'
TURNING = 'all, and the camera turns by 0.1 mrad'

# Name, segmentation, method, background removed, window held.
LOCATORS: dict[str, tuple[str, str, bool, bool]] = {
    'centroid, Shio & Otsu': ('otsu_window', 'centroid', False, False),
    'centroid, histogram': ('histogram', 'centroid', False, False),
    'centroid, extended': ('histogram_extended', 'centroid', False, False),
    'centroid, shortened': ('histogram_shortened', 'centroid', False, False),
    'centroid, extended, background removed': ('histogram_extended', 'centroid', True, False),
    'centroid, extended, window held': ('histogram_extended', 'centroid', True, True),
    'one Gaussian, linear, histogram': ('histogram', 'gaussian_linear', False, False),
    'three Gaussians, LM, Shio & Otsu': ('otsu_window', 'multi_gaussian_lm', False, False),
    'maximum likelihood, extended': ('histogram_extended', 'maximum_likelihood', True, False),
}
LM = 'three Gaussians, LM, Shio & Otsu'
CENTROID = 'centroid, extended'
CENTROIDS = tuple(name for name in LOCATORS if name.startswith('centroid'))[:4]

# What of a defect it would take: sizes over which it is raised, alone, for LM. What is drawn again
# at each place or look scatters; the trailing edge does not and is not among them.
SIZES: dict[str, tuple[str, tuple[float, ...]]] = {
    'noise': ('DN', (1.0, 4.0, 12.0, 30.0)),
    'per_line': ('px rms', (0.05, 0.2, 0.5, 1.0)),
    'per_frame': ('px rms', (0.02, 0.05, 0.15, 0.4)),
    'caliper': ('inches rms', (0.001, 0.01, 0.03, 0.1)),
    'turn': ('mrad rms', (0.05, 0.15, 0.3, 0.6)),
}


def cases(quick: bool) -> Sequence[Case]:
    """Return the causes for both targets, and the sizes for the lamp."""
    count = SEEDS[0] if quick else SEEDS[1]
    parts = [
        list(range(first, min(first + TOGETHER, count))) for first in range(0, count, TOGETHER)
    ]
    jobs: list[Case] = [
        {'cause': name, 'target': target, 'seeds': seeds}
        for name in CAUSES for target in TARGETS for seeds in parts
    ]
    for name, (_, sizes) in SIZES.items():
        jobs += [
            {'raised': name, 'size': size, 'seeds': seeds} for size in sizes for seeds in parts
        ]
    return jobs


def measure(case: Case) -> Measured:
    """Take the sequences and locate them: the errors are from the places that were asked for."""
    raised = 'raised' in case
    conditions = (
        _raised(case['raised'], case['size']) if raised else CAUSES[case['cause']]
    )
    target = 'active' if raised else case['target']
    names = [LM, CENTROID] if raised else list(LOCATORS)
    found: dict[str, list[dict[str, float | int | None]]] = {}
    for seed in case['seeds']:
        sequence = draw(TARGETS[target], STEP, conditions, seed)
        for name in names:
            segmentation, method, removed, held = LOCATORS[name]
            for averaged in (False, True):
                x = placed(
                    sequence, segmentation, method, averaged=averaged, removed=removed, held=held
                )
                key = f'{name}|{"multi" if averaged else "single"}'
                found.setdefault(key, []).append(figures_of(x, sequence.asked))
    return {'found': found}


def _raised(name: str, size: float) -> Conditions:
    """Return one defect of that size, with the noise of 1 DN that no camera is without."""
    if name == 'noise':
        return Conditions(noise=SensorNoise(np.inf, size))
    if name == 'caliper':
        return Conditions(caliper=size)
    if name == 'turn':
        return Conditions(turn=size)
    if name == 'per_line':
        return Conditions(chain=AnalogueChain(per_line=size))
    return Conditions(chain=AnalogueChain(per_frame=size))


def _of(entries: Sequence[dict[str, float | None]], name: str) -> NDArray[np.float64]:
    """Return one figure of all sequences that have it."""
    return np.array([entry[name] for entry in entries if entry[name] is not None], dtype=float)


def _rms(values: NDArray[np.float64]) -> float:
    """Return the root of the mean square."""
    return math.sqrt(float(np.mean(values**2)))


def _entries(
    results: Sequence[tuple[Case, Measured]], key: str, **which: object
) -> list[dict[str, float | None]]:
    """Return what was found in all cases of this kind."""
    return [
        entry for case, measured in results
        if all(case.get(name) == value for name, value in which.items())
        for entry in measured['found'].get(key, [])
    ]


def conclude(results: Sequence[tuple[Case, Measured]]) -> Findings:
    """Lay out the causes, what size each would need, and what holds of the thesis' results."""
    limits = {name: bound(target, 1) for name, target in TARGETS.items()}
    table, rows, columns = _laid_out(results, limits)
    needed, curves = _needed(results)
    here = {
        name: table['active', TOGETHER_ALL, f'{name}|single'] for name in LOCATORS
    }
    ratios = ratio_of_looks()
    everything = table['active', TOGETHER_ALL, f'{LM}|single']
    severest = max(
        table[target, cause, f'{LM}|{looks}']['worst']
        for target in TARGETS for cause in CAUSES if cause != TURNING
        for looks in ('single', 'multi')
    )
    centroids = [
        table[target, TOGETHER_ALL, f'{name}|single']['worst']
        for target in TARGETS for name in CENTROIDS
    ]
    silent = [
        table[target, 'rounding to 8 bit', f'{name}|single']['worst']
        for target in TARGETS for name in CENTROIDS
    ]
    held = table['active', TOGETHER_ALL, 'centroid, extended, window held|single']
    left, taken = (
        table['passive', 'noise 1 DN', f'{name}|single']['apart']
        for name in (CENTROID, 'centroid, extended, background removed')
    )
    moving = table['active', TOGETHER_ALL, 'centroid, extended, background removed|single']
    best = table['active', TOGETHER_ALL, 'maximum likelihood, extended|single']
    turning = table['active', TURNING, f'{LM}|single']
    variances = [float(row[k]) for row in load('table_5_7').rows for k in (4, 6)]
    goal = float(load('results_5').statements['goal'].value)
    quarter = float(load('results_5').statements['centroid'].value)
    return Findings(
        shows=(
            'What makes the centroid err by a quarter of a pixel is its window: a border that '
            'moves by a whole pixel from place to place takes light and background in or out. '
            f'Its worst of eleven places is {min(centroids):.2f} to {max(centroids):.2f} px with '
            f'all defects of the text, {min(silent):.2f} to {max(silent):.2f} px with nothing '
            'but rounding. Of the printed Gaussian it is the background: with noise alone its '
            f'extended window gives {left:.3f} px rms with it and {taken:.3f} without; of the '
            'lamp it is the tails too, which the border cuts. '
            'In a window that is held, its background taken off, the steps scatter '
            f'with {held["variance"]:.5f} px^2 in place of {moving["variance"]:.3f}, though the '
            f'light that it cuts off shrinks them to {held["mean"]:.3f} px. The trailing edge '
            'moves every place alike: by '
            f'{table["active", "trailing edge", f"{LM}|single"]["rms"]:.2f} px for LM, of which '
            f'{table["active", "trailing edge", f"{LM}|single"]["apart"]:.3f} px are left when '
            'the common offset is off. Of the three Gaussians no defect at the size of the text, '
            f'nor all together (active target, one look: {everything["apart"]:.3f} px rms, worst '
            f'{everything["worst"]:.2f} px), makes {quarter} px but for the common offset (either '
            f'target, worst {severest:.2f} px): it takes {needed["turn"]} of turning of the '
            f'camera at each setting, {needed["caliper"]} of the stage, or {needed["per_frame"]} '
            'from frame to '
            'frame. As the mean of five looks did not help the thesis (its variances are '
            f'{ratios:.2f} of those of one look, the median, where what is new in each look '
            'would give 0.2), what it suffered from stays for all looks of a place: the stage or '
            'the tripod, or the phase of the pixels.'
        ),
        agreement=(
            f'the centroid errs by {quarter} px for the border of its window; nothing of the '
            'size in the text makes three Gaussians err as much'
        ),
        tables=[
            Table('causes', f'Causes: errors at steps of {STEP} px',
                  [*columns, 'Cramer-Rao bound, one look, px'], rows),
            Table('causes_sizes', 'What size a defect, alone, would need for a worst of eleven '
                  f'places of {quarter} px with three Gaussians',
                  ['defect', 'size needed', 'size in the text'],
                  [[name, needed[name], _in_text(name)] for name in SIZES]),
            Table('causes_implied', 'What the printed variances of three Gaussians, '
                  'Levenberg-Marquardt, circular, one look, ask for',
                  ['target', 'step, px', 'variance printed, px^2',
                   'scatter of each place, sqrt(variance / 2), px', 'beyond ours, px',
                   'as a turn of the camera, mrad', 'as a place of the stage, inches'],
                  implied({
                      target: table[target, TOGETHER_ALL, f'{LM}|single']['variance']
                      for target in TARGETS
                  })),
            Table('results_5_6', 'The results of section 5.6, page 117, here',
                  ['result', 'here', 'holds'], results_here(here)),
        ],
        figures={
            'causes_active': draw_causes('active', list(CAUSES), list(LOCATORS), table,
                                         limits['active']),
            'causes_passive': draw_causes('passive', list(CAUSES), list(LOCATORS), table,
                                          limits['passive']),
            'causes_sizes': draw_sizes(curves, {name: SIZES[name][0] for name in SIZES},
                                       quarter, limits['active']),
        },
        checks=_checks(
            goal, quarter, centroids, held, moving, severest, everything, best, turning, variances
        ),
    )


def _laid_out(
    results: Sequence[tuple[Case, Measured]], limits: dict[str, float]
) -> tuple[dict[tuple[str, str, str], dict[str, float]], list[list[Cell]], list[str]]:
    """Return the figures by target, cause and way; the same in rows, and their columns."""
    rows: list[list[Cell]] = []
    table: dict[tuple[str, str, str], dict[str, float]] = {}
    for target in TARGETS:
        for cause in CAUSES:
            for name in LOCATORS:
                row: list[Cell] = [target, cause, name]
                for looks in ('single', 'multi'):
                    entries = _entries(results, f'{name}|{looks}', cause=cause, target=target)
                    summary = {
                        'rms': _rms(_of(entries, 'rms')),
                        'apart': _rms(_of(entries, 'apart')),
                        'worst': float(np.median(_of(entries, 'worst'))),
                        'variance': float(np.mean(_of(entries, 'variance'))),
                        'mean': float(np.mean(_of(entries, 'mean'))),
                    }
                    table[target, cause, f'{name}|{looks}'] = summary
                    row += list(summary.values())
                rows.append([*row, limits[target]])
    columns = ['target', 'cause', 'locator']
    for looks in ('one look', 'mean of five'):
        columns += [
            f'rms, {looks}, px', f'less the offset, {looks}, px', f'worst of eleven, {looks}, px',
            f'variance of the steps, {looks}, px^2', f'mean step, {looks}, px',
        ]
    return table, rows, columns


def _checks(
    goal: float, quarter: float, centroids: Sequence[float], held: dict[str, float],
    moving: dict[str, float], severest: float, everything: dict[str, float],
    best: dict[str, float], turning: dict[str, float], printed: Sequence[float],
) -> list[Check]:
    """Hold the errors of the causes against what the thesis has."""
    least, most = min(printed), max(printed)
    return [
        Check('the windows of the thesis alone make its centroid err by a quarter pixel',
              f'a worst of eleven places of {quarter} px within a factor of 2, all defects',
              f'{np.median(centroids):.3f} px, the median of targets and segmentations',
              0.5 <= float(np.median(centroids)) / quarter <= 2.0),
        Check('it is the border of the window that moves',
              'a tenth of the variance of the steps, or less, where the window is held',
              f'{held["variance"]:.5f} px^2 of {moving["variance"]:.4f}',
              held['variance'] <= 0.1 * moving['variance']),
        Check('no defect at the size of the text, nor all together, makes three Gaussians err '
              'by that much but for the common offset',
              f'a worst of eleven places below {quarter} px, the median of the sequences, for '
              'each cause but the turning camera, both targets, one look and five',
              f'{severest:.3f} px at most; {everything["worst"]:.3f} px with all, active '
              'target, one look', severest < quarter),
        Check('maximum likelihood is within the goal with all defects, active target, one '
              'look, but for the common offset',
              f'{goal} px rms', f'{best["apart"]:.4f} px', best['apart'] <= goal),
        Check('turning of the camera, of 0.1 mrad, gives the printed variance of LM',
              f'{least:.4f} to {most:.4f} px^2, those of the active target',
              f'{turning["variance"]:.4f} px^2', least <= turning['variance'] <= most),
    ]


def _needed(
    results: Sequence[tuple[Case, Measured]],
) -> tuple[dict[str, str], dict[str, tuple[list[float], list[float], list[float]]]]:
    """Return the size of each defect at which LM errs by 0.25 px, and the curves."""
    quarter = float(load('results_5').statements['multi_gaussian'].value)
    needed, curves = {}, {}
    for name, (unit, sizes) in SIZES.items():
        worst: list[float] = []
        centroid: list[float] = []
        for size in sizes:
            for key, into in ((LM, worst), (CENTROID, centroid)):
                entries = _entries(results, f'{key}|single', raised=name, size=size)
                into.append(float(np.median(_of(entries, 'worst'))))
        curves[name] = (list(sizes), worst, centroid)
        if max(worst) < quarter:
            needed[name] = f'more than {sizes[-1]:g} {unit}'
            continue
        place = float(np.exp(np.interp(
            math.log(quarter), np.log(np.maximum.accumulate(worst)), np.log(sizes)
        )))
        needed[name] = f'{place:.2g} {unit}'
    return needed, curves


def _in_text(name: str) -> str:
    """Return the size that the text gives."""
    return {
        'noise': f'{NOISE.read_noise:g} DN (page 18)',
        'per_line': '1/20 px (page 19)',
        'per_frame': 'none; 1/20 px if its remainder is common to the lines',
        'caliper': '0.001 inch (page 95)',
        'turn': 'none; the pan and tilt mount is on page 95',
    }[name]


STUDY = Study(
    name='causes',
    title='Which defect turns 0.05 px into 0.25 px',
    source='Sections 5.5 and 5.6, pages 106 to 117',
    cases=cases,
    measure=measure,
    conclude=conclude,
)
