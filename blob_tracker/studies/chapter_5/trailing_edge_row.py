"""Figure 5.3: the row that falls off fast on the right, and what it does to the centroid."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.camera.trailing_edge import TrailingEdge
from blob_tracker.location.centroid import centroid_1d
from blob_tracker.location.pulse import integrated_profile
from blob_tracker.simulation.trailing_edge import MEMORY_PX, peaked, PEAKING
from blob_tracker.studies.axes import COLOURS
from blob_tracker.studies.chapter_5.pictures import MARKERS, THIN
from blob_tracker.studies.printed import load
from blob_tracker.studies.study import Case, Cell, Check, Findings, Measured, Study, Table
from matplotlib.figure import Figure
import numpy as np
from numpy.typing import NDArray

EDGE = TrailingEdge(PEAKING, MEMORY_PX)
BACKGROUND = 10.0  # DN above black
HALF = 3.0  # sigma, of the window that the centroid is taken over
WIDTHS = (1.0, 1.5, 2.5, 4.0, 7.0, 12.0, 20.0)  # px, sigma
AMPLITUDES = (1.0, 3.0, 10.0, 20.0, 40.0, 80.0, 160.0, 240.0)  # DN ahead of the filter
PHASES = tuple(np.linspace(-0.5, 0.5, 21).tolist())


def cases(quick: bool) -> Sequence[Case]:
    """Return one case for each width; there is nothing to draw by chance."""
    return [{'sigma': sigma} for sigma in WIDTHS]


def _row(sigma: float, amplitude: float, phase: float) -> tuple[NDArray[np.float64], float]:
    """Return a row behind the filter, clipped at black, and the place of its blob."""
    half = int(np.ceil(8 * sigma)) + 40
    x = half + phase
    light = BACKGROUND + amplitude * integrated_profile(2 * half + 1, x, sigma)[0]
    return np.maximum(peaked(light, EDGE), 0.0), x


def _flanks(row: NDArray[np.float64]) -> tuple[float, float]:
    """Return the lengths of the rise and of the fall between 10 and 90 % of the peak, px."""
    light = row - BACKGROUND
    top = int(np.argmax(light))

    def reach(flank: NDArray[np.float64], level: float) -> float:
        k = int(np.argmax(flank < level))
        return k - (level - flank[k]) / (flank[k - 1] - flank[k])

    lengths = [
        reach(flank, 0.1 * light[top]) - reach(flank, 0.9 * light[top])
        for flank in (light[top::-1], light[top:])
    ]
    return float(lengths[0]), float(lengths[1])


def measure(case: Case) -> Measured:
    """Measure the flanks and the bias of the centroid in a window of +-3 sigma about the truth."""
    sigma = case['sigma']
    window = int(np.ceil(HALF * sigma))
    biases = []
    for amplitude in AMPLITUDES:
        at_phases = []
        for phase in PHASES:
            row, x = _row(sigma, amplitude, phase)
            middle = round(x)
            part = row[middle - window:middle + window + 1] - BACKGROUND
            at_phases.append(float(centroid_1d(part)) + middle - window - x)
        biases.append(at_phases)
    row, _ = _row(sigma, _shown(sigma), 0.0)
    return {
        'biases': biases,
        'flanks': _flanks(row),
        'row': row.tolist(),
        'without': (BACKGROUND + _shown(sigma) * integrated_profile(
            row.size, (row.size - 1) / 2, sigma)[0]).tolist(),
        'peak': float(row.max()),
    }


def _shown(sigma: float) -> float:
    """Return the amplitude at which the row's peak is just below 250 DN."""
    row, _ = _row(sigma, 1.0, 0.0)
    return 235.0 / (float(row.max()) - BACKGROUND)


def conclude(results: Sequence[tuple[Case, Measured]]) -> Findings:
    """Draw the row, and the bias against amplitude, width and phase."""
    text = load('figure_5_3').statements
    rows: list[list[Cell]] = []
    for case, measured in results:
        for amplitude, biases in zip(AMPLITUDES, measured['biases']):
            rise, fall = measured['flanks']
            rows.append([
                case['sigma'], 4.0 * case['sigma'], amplitude, float(np.mean(biases)),
                float(np.ptp(biases)), rise, fall, fall / rise,
            ])
    by_width = {case['sigma']: measured for case, measured in results}
    narrow, wide = by_width[2.5], by_width[20.0]
    ratio, ratio_wide = (m['flanks'][1] / m['flanks'][0] for m in (narrow, wide))
    bias = {
        amplitude: np.array(narrow['biases'][index]) for index, amplitude in enumerate(AMPLITUDES)
    }
    return Findings(
        shows=(
            f'Behind a peaking filter of {PEAKING:g} and {MEMORY_PX:g} px a blob of '
            f'{text["small"].value} px falls in {ratio:.2f} of the length of its rise and dives '
            f'through black, one of {text["wide"].value} px in {ratio_wide:.2f}, and a column '
            'not at all. The centroid of the small one is drawn to the left by '
            f'{-bias[1.0].mean():.2f} px where it is faint and by {-bias[160.0].mean():.2f} px '
            'where it is clipped; over a pixel the bias varies by '
            f'{np.ptp(bias[160.0]):.3f} px: it is an offset, not a '
            'scatter, as long as amplitude and width stay.'
        ),
        agreement='the shape in words; the figure prints no numbers',
        tables=[Table(
            'figure_5_3', 'Bias of the centroid in +-3 sigma, one row without noise',
            ['sigma, px', 'width (4 sigma), px', 'amplitude, DN', 'bias, mean over phases, px',
             'bias, range over phases, px', 'rise 10 to 90 % at full scale, px',
             'fall 90 to 10 % at full scale, px', 'fall over rise'], rows,
        )],
        figures={'figure_5_3': _draw_rows(narrow, wide), 'bias_5_3': _draw_biases(by_width)},
        checks=[
            Check('a small, bright blob falls much faster than it rises', 'in 0.8 of it or less',
                  f'{ratio:.3f}', ratio <= 0.8),
            Check(f'one of {text["wide"].value} px does not', '0.9 to 1.1', f'{ratio_wide:.3f}',
                  0.9 <= ratio_wide <= 1.1),
        ],
    )


def _draw_rows(narrow: Measured, wide: Measured) -> Figure:
    """Draw both rows as the camera shows them and as they would be without its filter."""
    figure = Figure(figsize=(8, 4.5), layout='constrained')
    for axes, measured, reach, title in zip(
        figure.subplots(1, 2, sharey=True), (narrow, wide), (20, 80),
        ('10 px wide', '80 px wide'),
    ):
        count = len(measured['row'])
        k = np.arange(count) - (count - 1) / 2
        light = np.array(measured['without'])
        light = BACKGROUND + (light - BACKGROUND) * (
            (measured['peak'] - BACKGROUND) / (light.max() - BACKGROUND)
        )
        axes.plot(k, light, color=COLOURS[1], linewidth=1.0, label='without, to the same peak')
        axes.step(k, measured['row'], where='mid', color=COLOURS[0], label='with the filter')
        axes.set_xlim(-reach, reach)
        axes.set_xlabel('pixel of the row, from the blob')
        axes.set_title(title, fontsize=9)
        axes.grid(True, **THIN)
    figure.axes[0].set_ylabel('DN')
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc='outside lower center',
                  ncols=2, fontsize=8)
    figure.suptitle('A row like Figure 5.3', fontsize=10)
    return figure


def _draw_biases(by_width: dict[float, Measured]) -> Figure:
    """Draw the bias against amplitude, width and phase."""
    figure = Figure(figsize=(9.5, 4.2), layout='constrained')
    left, middle, right = figure.subplots(1, 3)
    for index, (sigma, measured) in enumerate(list(by_width.items())[:5]):
        mean = [-float(np.mean(biases)) for biases in measured['biases']]
        style = {'color': COLOURS[index], 'marker': MARKERS[index], 'markersize': 4}
        left.plot(AMPLITUDES, mean, label=f'sigma {sigma:g} px', **style)
        full = np.array(measured['biases'][AMPLITUDES.index(160.0)])
        right.plot(PHASES, full - full.mean(), **style)
    for index, amplitude in enumerate((3.0, 20.0, 80.0, 240.0)):
        k = AMPLITUDES.index(amplitude)
        middle.plot(
            list(by_width), [-float(np.mean(m['biases'][k])) for m in by_width.values()],
            color=COLOURS[index], marker=MARKERS[index], markersize=4, label=f'{amplitude:g} DN',
        )
    left.set_xscale('log')
    left.set_xlabel('amplitude, DN')
    left.set_ylabel('centroid too far left by, px')
    middle.set_xscale('log')
    middle.set_xlabel('sigma, px')
    middle.set_ylabel('centroid too far left by, px')
    right.set_xlabel('phase within the pixel, px')
    right.set_ylabel('bias less its mean, 160 DN, px')
    for axes in (left, middle, right):
        axes.grid(True, **THIN)
    middle.legend(fontsize=8)
    figure.legend(*left.get_legend_handles_labels(), loc='outside lower center', ncols=5,
                  fontsize=8)
    figure.suptitle(
        f'Bias of the centroid in +-3 sigma on {BACKGROUND:g} DN, no noise (the bound is 0)',
        fontsize=10,
    )
    return figure


STUDY = Study(
    name='figure_5_3',
    title='The trailing edge: a row, and the bias of the centroid',
    source='Figure 5.3, page 103; page 102',
    cases=cases,
    measure=measure,
    conclude=conclude,
)
