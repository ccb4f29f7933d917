"""Table 5.1: how far the camera must be moved for one pixel, from shifts that are known."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

from blob_tracker.studies.axes import COLOURS
from blob_tracker.studies.chapter_5.displacements import (
    bound, draw, LABORATORY, placed, PX_PER_MRAD, STEPS, TARGETS,
)
from blob_tracker.studies.chapter_5.pictures import THIN
from blob_tracker.studies.printed import load
from blob_tracker.studies.study import Case, Cell, Check, Findings, Measured, Study, Table
from matplotlib.figure import Figure
import numpy as np

SEEDS = (12, 120)  # quick and full
TOGETHER = 12
# The control point is placed as well as the thesis could place anything: by the centroid of the
# passive target, over steps of 1 px, whatever the distance.
SEGMENTATION, METHOD = 'otsu_window', 'centroid'


def cases(quick: bool) -> Sequence[Case]:
    """Return the calibrations, a few seeds a case."""
    count = SEEDS[0] if quick else SEEDS[1]
    return [
        {'row': row, 'seeds': list(range(first, first + TOGETHER))}
        for row in range(len(load('table_5_1').rows))
        for first in range(0, count, TOGETHER)
    ]


def measure(case: Case) -> Measured:
    """
    Estimate the displacement of one pixel (thesis, eq. 5.1) from eleven places.

    The slope of the places in the picture over those that the caliper reads, by least squares.
    """
    _, step, inches = load('table_5_1').rows[case['row']]
    per_pixel = float(inches) / float(step)
    found: dict[str, list[float]] = {METHOD: [], 'multi_gaussian_lm': []}
    for seed in case['seeds']:
        random = np.random.default_rng([seed, case['row']])
        sequence = draw(TARGETS['passive'], '1.00', LABORATORY, seed + 1000 * case['row'])
        # The stage is where it is; the caliper reads it with its error.
        stage = (sequence.truth - sequence.truth[0]) * per_pixel
        read = stage + LABORATORY.caliper * random.standard_normal(stage.size)
        for method, slopes in found.items():
            x = placed(sequence, SEGMENTATION, method, averaged=False, removed=False)
            slopes.append(float(1.0 / np.polyfit(read, x, 1)[0]))
    return {'inches': found}


def conclude(results: Sequence[tuple[Case, Measured]]) -> Findings:
    """Lay the calibrations beside what was put in, as it is printed, and beside the pinhole."""
    printed = load('table_5_1')
    caliper = float(printed.statements['caliper'].value)
    rows: list[list[Cell]] = []
    figure = Figure(figsize=(7, 4.5), layout='constrained')
    axes = figure.subplots()
    agree, spread = [], []
    for index, (feet, step, inches) in enumerate(printed.rows):
        estimates = {
            method: np.array([
                value for case, measured in results if case['row'] == index
                for value in measured['inches'][method]
            ])
            for method in (METHOD, 'multi_gaussian_lm')
        }
        per_pixel = float(inches) / float(step)
        wanted = estimates[METHOD] * float(step)
        pinhole = float(feet) * 12.0 * 1e-3 / PX_PER_MRAD * float(step)
        agree.append(abs(float(wanted.mean()) - float(inches)) / float(wanted.std(ddof=1)))
        spread.append(float(wanted.std(ddof=1)) / float(inches))
        in_pixels = caliper / per_pixel
        rows.append([
            float(feet), float(step), float(inches), float(wanted.mean()),
            float(wanted.std(ddof=1)), float(wanted.mean()) - float(inches),
            float(estimates['multi_gaussian_lm'].std(ddof=1) * float(step)), pinhole,
            100.0 * (float(inches) / pinhole - 1.0), in_pixels, sqrt(2.0) * in_pixels,
            100.0 * sqrt(2.0) * in_pixels / float(step), 0.1 * sqrt(2.0) * in_pixels,
            2.0 * in_pixels**2,
        ])
        axes.hist(
            100.0 * (wanted / float(inches) - 1.0), bins=np.linspace(-5, 5, 41).tolist(),
            histtype='step', linewidth=1.5 - 0.3 * index, color=COLOURS[index],
            label=f'{feet} ft, steps of {step} px',
        )
    limit = bound(TARGETS['passive'], 1)
    least = 100.0 * limit / sqrt(float(np.sum((np.arange(11) - 5.0) ** 2)))
    axes.axvspan(-least, least, color='#000000', alpha=0.25,
                 label=f'+- Cramer-Rao bound of eleven places, {least:.3f} %')
    axes.set_xlabel('inches per pixel found, difference from those put in, %')
    axes.set_ylabel('calibrations')
    axes.grid(True, **THIN)
    axes.legend(fontsize=8)
    figure.suptitle('Table 5.1 by known shifts: centroid, eleven places 1 px apart', fontsize=10)
    small = rows[-1]
    return Findings(
        shows=(
            'The stage is moved by the printed inches per pixel, so the table cannot be '
            'reproduced: what is tested is the calibration. One by eleven known shifts of 1 px is '
            f'good to {100 * max(spread):.1f} % with the centroid of the thesis, which adds no '
            f'bias to it beyond {max(agree):.2f} of that; the printed fourth digit is beyond it, '
            f'as it says itself. One thousandth of an inch is {small[9]:.4f} px at {small[0]:.0f} '
            f'ft, so the caliper alone puts {small[10]:.4f} px, {small[11]:.1f} %, on each step '
            f'of 0.05 px and a variance of {small[13]:.1e} px^2 on the steps: a hundredth of the '
            'printed ones. The pinhole of section 2.1 (6 mm, 1.67 mrad a pixel) wants '
            f'{rows[0][7]:.4f} inches at 8 ft and {rows[1][7]:.4f} at 16 ft: the distances '
            f'(about, in the table) were {rows[0][8]:.0f} and {rows[1][8]:.0f} % off.'
        ),
        agreement=f'put in as printed; one calibration is good to {100 * max(spread):.1f} %',
        tables=[Table(
            'table_5_1', 'Table 5.1, page 104: displacement of the camera for that of the picture',
            ['distance, ft', 'step, px', 'printed and put in, inches', 'found, mean, inches',
             'found, standard deviation, inches', 'difference, inches',
             'standard deviation with three Gaussians, inches', 'pinhole, inches',
             'printed off the pinhole, %', 'caliper, px', 'caliper on a step, px',
             'of the step, %', 'caliper on the mean of ten steps, px',
             'caliper on the variance of the steps, px^2'], rows,
        )],
        figures={'table_5_1': figure},
        checks=[
            Check('the centroid adds no bias to the calibration',
                  'within one standard deviation of a calibration of what was put in, the mean of '
                  'all',
                  f'{max(agree):.2f} of it at most', max(agree) < 1.0),
            Check('the caliper is no cause', 'on a step below a tenth of one of 0.05 px, rms',
                  f'{small[11]:.1f} % of it', float(str(small[10])) < 0.1 * float(STEPS[0])),
        ],
    )


STUDY = Study(
    name='table_5_1',
    title='Calibration by known shifts',
    source='Table 5.1, page 104; eq. 5.1, page 98',
    cases=cases,
    measure=measure,
    conclude=conclude,
)
