"""What the printed numbers of chapter 5 say about their cause, and its results beside ours."""

from __future__ import annotations

from collections.abc import Mapping
from math import sqrt

from blob_tracker.studies.chapter_5.displacements import inches_per_pixel, PX_PER_MRAD
from blob_tracker.studies.printed import load
from blob_tracker.studies.study import Cell
import numpy as np


def ratio_of_looks() -> float:
    """
    Return the median ratio of the printed variances, mean of five looks over one look.

    What is drawn again in each look would make it a fifth; what stays for all of them, one.
    """
    ratios = []
    for name in ('table_5_2', 'table_5_3', 'table_5_6', 'table_5_7'):
        rows = load(name).rows
        for one, five in zip(rows[::2], rows[1::2]):
            ratios += [float(five[k]) / float(one[k]) for k in range(4, len(one), 2)]
    return float(np.median(ratios))


def implied(ours: Mapping[str, float]) -> list[list[Cell]]:
    """
    Return what scatter of the places the printed variances of the steps imply.

    A step is the difference of two places: places that scatter by s give it a variance 2 s^2.

    Parameters
    ----------
    ours : mapping
        Variance of the steps with all defects of the text for each target, px^2.

    """
    rows: list[list[Cell]] = []
    for target, name in (('passive', 'table_5_6'), ('active', 'table_5_7')):
        for row in load(name).rows:
            if row[1:3] != ('Least Squares', 'single'):
                continue
            variance = float(row[4])
            beyond = sqrt(max(variance - ours[target], 0.0) / 2.0)
            rows.append([
                target, float(row[0]), variance, sqrt(variance / 2.0), beyond,
                beyond / PX_PER_MRAD, beyond * inches_per_pixel(row[0]),
            ])
    return rows


def results_here(here: Mapping[str, Mapping[str, float]]) -> list[list[Cell]]:
    """Return which results of page 117 hold in the virtual lab, for the active target."""
    said = load('results_5').statements
    goal, quarter = float(said['goal'].value), float(said['centroid'].value)
    linear = here['one Gaussian, linear, histogram']
    lm = here['three Gaussians, LM, Shio & Otsu']
    likelihood = here['maximum likelihood, extended']
    worst = [
        here[f'centroid, {window}']['worst']
        for window in ('Shio & Otsu', 'histogram', 'extended', 'shortened')
    ]
    worse = [
        name for name, fit in (('the linear fit', linear), ('maximum likelihood', likelihood))
        if fit['apart'] > lm['apart']
    ]
    best = min(here, key=lambda name: here[name]['apart'])
    return [
        [said['single_gaussian'].says,
         f'the linear fit scatters by {linear["apart"]:.3f} px rms, three Gaussians by '
         f'{lm["apart"]:.3f}; maximum likelihood with one Gaussian by '
         f'{likelihood["apart"]:.3f}',
         f'for {worse[0]} alone' if len(worse) == 1
         else 'yes' if worse else 'no'],
        [f'{said["goal"].says}: {goal}',
         f'three Gaussians {lm["apart"]:.3f} px rms (worst {lm["worst"]:.3f}), maximum '
         f'likelihood {likelihood["apart"]:.3f} (worst {likelihood["worst"]:.3f}), all less the '
         'common offset',
         f'no: {best}, {here[best]["apart"]:.3f} px' if here[best]['apart'] <= goal else 'yes'],
        [f'{said["centroid"].says}: {quarter}',
         f'worst place {min(worst):.2f} to {max(worst):.2f} px in the windows of the thesis',
         _holds(min(worst), quarter)],
        [f'{said["multi_gaussian"].says}: {quarter}', f'worst place {lm["worst"]:.3f} px',
         _holds(lm['worst'], quarter)],
    ]


def _holds(ours: float, printed: float) -> str:
    """Return whether a printed accuracy holds: within a factor of 2, as the checks ask it."""
    if 0.5 * printed <= ours <= 2.0 * printed:
        return 'yes, within a factor of 2'
    return f'no: {"better" if ours < printed else "worse"} by a factor of 2 or more'
