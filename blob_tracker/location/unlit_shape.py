"""A light of any shape that is in the unlit window as well: fainter, and where it was then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

from blob_tracker.kernel import Array, exact_kernel
from blob_tracker.location.hypotheses import FALSE_ALARM, Pair
from blob_tracker.location.pair_likelihood import climb, Floats, Model, Optimum
from blob_tracker.location.pair_model import BACKGROUND, brightest, X, Y
from blob_tracker.location.unlit_pulse import outdoes_texture
import numpy as np

BEFORE = -0.5  # of a flash's displacement: the unlit frame is halfway to the last lit one
BRIGHTER = 1.0  # than the lit light: such a one in the unlit frame is another one
UNDECIDED = 12.0  # of twice the log-likelihood, below which a ghost is likelier beforehand
STEPS = 40  # a fit that takes more goes along a valley that has no top
MOST_CHI2 = 3.0  # beyond which the light is not of that shape: time is not spent on it
STEEPEST = 2.0  # of the share, a row: the next one has it all
FARTHEST = 20.0  # shares: how far from the middle of the window the switch may be
EVEN = 4.0  # standard deviations of the slope, below which all rows have the same share
FIRST_SLOPES = (0.0, -0.15, 0.15)  # of the share, a row, with which the fits begin
STILL_ON = (
    'the light is still on in the unlit frame ({:.0f} % of it): shorten the exposure, shift the '
    "flash's phase or flash at half the rate"
)
SWITCHES = (
    'the flash switches while the rows of the light are exposed ({:.0f} % of it is in the lit '
    'frame): shift its phase, shorten the exposure or use a global shutter'
)


@dataclass(frozen=True)
class Shape:
    """
    The fit of a shape that is in the lit window alone.

    Parameters
    ----------
    optimum : Optimum
        The top of its likelihood.
    model : callable
        Its means and slopes.
    start : (p,) array
        Where its fit began.
    lower, upper : (p,) arrays
        What its parameters are held between.
    prior : two (p,) arrays, optional
        As in `climb`.
    warning : str
        That it is in the unlit window, too; '' where it is not.

    """

    optimum: Optimum
    model: Model
    start: Floats
    lower: Floats
    upper: Floats
    prior: tuple[Floats, Floats] | None = None
    warning: str = ''


def with_ghost(pair: Pair, shape: Shape) -> Shape:
    """
    Return the shape with what is left of it in the unlit window, where that is shown to be.

        lit = b + S(x),    unlit = b + g S(x + s)

    Or, where that is clearly likelier, a lamp of that shape behind the light, in both windows,
    lit = b + S(x) + g S(x + s), or a light whose rows are shared out between the two frames, as
    `switched` has it: lit = b + s_j S(x), unlit = b + (1 - s_j) S(x + s).
    """
    if pair.unlit is None or not pair.haunted:
        return shape
    # What is in the unlit window has drawn the fit of both away from the lit light.
    lit = replace(pair, unlit=None)
    alone = _likeliest([
        climb(lit, shape.model, start, shape.lower, shape.upper, shape.prior, steps=STEPS)
        for start in (shape.start, shape.optimum.theta)
    ])
    if alone is None or alone.chi2 > MOST_CHI2:
        # It is not of that shape, or its rows are cut.
        best, lamp = None, None
    else:
        best = _fit(pair, shape, alone, in_lit=0.0)
        if best is not None and not outdoes_texture(pair, best.optimum):
            return shape
        lamp = _fit(pair, shape, alone, in_lit=1.0)
    price = math.log(pair.pixels.size)
    shared = _shared(pair, shape, price)
    if shared is not None and (best is None or _gain(shared, best) > price * (
        shared.optimum.parameters - best.optimum.parameters
    )):
        best = shared
    if lamp is not None and (best is None or _gain(lamp, best) > UNDECIDED):
        best = lamp
    if best is None:
        return shape
    fixed, each = FALSE_ALARM
    added = best.optimum.parameters - shape.optimum.parameters
    if _gain(best, shape) < fixed + each * added or not outdoes_texture(pair, best.optimum):
        return shape
    return best


def _gain(shape: Shape, other: Shape) -> float:
    """Return twice the log-likelihood of a shape over that of another one."""
    return 2.0 * (shape.optimum.log_likelihood - other.optimum.log_likelihood)


def _fit(pair: Pair, shape: Shape, alone: Optimum, in_lit: float) -> Shape | None:
    """Fit the shape and its ghost, of which such a share is in the lit window."""
    assert pair.unlit is not None
    theta, means = alone.theta, alone.means[0]
    x, y = brightest(pair.unlit)
    light = float(means.max()) - theta[BACKGROUND]
    left = float(pair.unlit[int(y), int(x)]) - float(np.median(pair.unlit))
    # Its brightest place, as the shape's may be off its middle.
    lit_x, lit_y = brightest(means)
    height, width = means.shape
    prior = _prior(pair, shape, 1)
    lower = np.append(shape.lower, [-width, -height, 0.0])
    upper = np.append(shape.upper, [width, height, BRIGHTER])
    model = _in_both(shape.model, in_lit)
    share = min(max(left / max(light, 1.0), 0.01), BRIGHTER)
    best = _likeliest([
        climb(
            pair, model, np.append(theta, [*shift, share]), lower, upper, prior, steps=STEPS
        )
        for shift in _first_shifts(pair, np.array([x - lit_x, y - lit_y]))
    ])
    if best is None:
        return None
    warning = '' if in_lit else STILL_ON.format(100.0 * best.theta[-1])
    return Shape(best, model, shape.start, lower, upper, prior, warning)


def _shared(pair: Pair, shape: Shape, price: float) -> Shape | None:
    """Fit the shape with its rows shared out between the windows, moving if they surely are."""
    assert pair.unlit is not None
    level = min(float(np.median(pair.unlit)), float(np.median(pair.lit)))
    both = replace(pair, lit=pair.lit + pair.unlit - level, unlit=None)
    whole = climb(
        both, shape.model, shape.optimum.theta, shape.lower, shape.upper, shape.prior, steps=STEPS
    )
    if whole is None or whole.chi2 > MOST_CHI2:
        return None
    light = whole.means[0] - whole.theta[BACKGROUND]
    share = float((pair.lit - level).sum() / max(light.sum(), 1.0))
    model, prior = _in_shares(shape.model), _prior(pair, shape, 2)

    def fit(start: Floats, away: Floats) -> Optimum | None:
        lower = np.concatenate([shape.lower, -away, [-FARTHEST, -STEEPEST]])
        upper = np.concatenate([shape.upper, away, [FARTHEST, STEEPEST]])
        return climb(pair, model, start, lower, upper, prior, steps=STEPS)

    best = _likeliest([
        fit(np.append(whole.theta, [0.0, 0.0, share, slope]), np.zeros(2))
        for slope in FIRST_SLOPES
    ])
    if best is None:
        return None
    moving = fit(best.theta, np.array(pair.lit.shape[::-1], dtype=float))
    if moving is not None and (
        abs(moving.theta[-1]) > EVEN * math.sqrt(moving.covariance[-1, -1])
        and 2.0 * (moving.log_likelihood - best.log_likelihood)
        > price * (moving.parameters - best.parameters)
    ):
        best = moving
    row = best.theta[Y] - 0.5 * (pair.lit.shape[0] - 1)
    part = min(max(float(best.theta[-2] + best.theta[-1] * row), 0.0), 1.0)
    return Shape(
        best, model, shape.start, shape.lower, shape.upper, prior, SWITCHES.format(100.0 * part)
    )


def _likeliest(found: Sequence[Optimum | None]) -> Optimum | None:
    """Return the highest of the tops that were found."""
    return max(
        (each for each in found if each is not None), key=lambda each: each.log_likelihood,
        default=None,
    )


def _first_shifts(pair: Pair, seen: Floats) -> list[Floats]:
    """Return where the ghost may be: by its brightest pixels, and by the light's motion."""
    if pair.motion is None:
        return [seen, np.zeros(2)]
    return [seen, BEFORE * pair.motion.flash]


def _in_both(model: Model, in_lit: float) -> Model:
    """Return the model of a shape in both windows; its last parameters are shift and share."""
    def fill(theta: Floats, means: Floats, slopes: Floats) -> None:
        own = theta.size - 3
        shift, share = theta[own:own + 2], theta[-1]
        model(theta[:own], means, slopes[:own])
        slopes[own:] = 0.0
        there = theta[:own].copy()
        there[[X, Y]] += shift
        left, by = np.zeros(means.shape), np.zeros((own, *means.shape))
        model(there, left, by)
        _add_ghost(means, slopes, left, by, float(theta[BACKGROUND]), float(share), in_lit)

    return fill


@exact_kernel
def _add_ghost(
    means: Array, slopes: Array, left: Array, by: Array, background: float, share: float,
    in_lit: float,
) -> None:
    """Add such a share of a shape, and its slopes, to both windows; `in_lit` of it to the lit."""
    own = by.shape[0]
    _, height, width = means.shape
    for k in range(2):
        part = in_lit if k == 0 else 1.0
        if part == 0.0:
            continue
        of_it = part * share
        for j in range(height):
            for i in range(width):
                light = left[0, j, i] - background
                means[k, j, i] += of_it * light
                for p in range(own):
                    if p != BACKGROUND:
                        slopes[p, k, j, i] += of_it * by[p, 0, j, i]
                slopes[own, k, j, i] = of_it * by[X, 0, j, i]
                slopes[own + 1, k, j, i] = of_it * by[Y, 0, j, i]
                slopes[own + 2, k, j, i] = part * light


def _in_shares(model: Model) -> Model:
    """
    Return the model of a shape whose rows are shared out between the windows.

    Its last parameters are the shift, the share of the lit window in the middle row, and what a
    row adds to it.
    """
    def fill(theta: Floats, means: Floats, slopes: Floats) -> None:
        own = theta.size - 4
        full, by = np.zeros(means.shape), np.zeros((own, *means.shape))
        slopes[:] = 0.0
        there = theta[:own].copy()
        for k in range(2):
            if k == 1:
                there[[X, Y]] += theta[own:own + 2]
            model(there, full, by)
            _share_out(
                means, slopes, full, by, float(theta[BACKGROUND]), float(theta[-2]),
                float(theta[-1]), k,
            )

    return fill


def compile_shares() -> None:
    """Compile what shares out the rows of a shape, and what adds its ghost, or load it."""
    own, windows = 5, (2, 1, 1)
    means, slopes = np.zeros(windows), np.zeros((own + 4, *windows))
    shape, by = np.zeros(windows), np.zeros((own, *windows))
    _share_out(means, slopes, shape, by, 0.0, 0.5, 0.0, 0)
    _add_ghost(means, slopes, shape, by, 0.0, 0.5, 0.0)


@exact_kernel
def _share_out(
    means: Array, slopes: Array, full: Array, by: Array, background: float, middle: float,
    steep: float, k: int,
) -> None:
    """Fill window k with its share of the rows of a shape, and the slopes of that."""
    own = by.shape[0]
    _, height, width = means.shape
    for j in range(height):
        row = j - 0.5 * (height - 1)
        share = middle + steep * row
        inside = 1.0 if 0.0 < share < 1.0 else 0.0
        share = min(max(share, 0.0), 1.0)
        part, sign = (share, 1.0) if k == 0 else (1.0 - share, -1.0)
        for i in range(width):
            light = full[0, j, i] - background
            means[k, j, i] = background + part * light
            for p in range(own):
                slopes[p, k, j, i] = 1.0 if p == BACKGROUND else part * by[p, 0, j, i]
            slopes[own, k, j, i] = k * slopes[X, k, j, i]
            slopes[own + 1, k, j, i] = k * slopes[Y, k, j, i]
            slopes[own + 2, k, j, i] = sign * inside * light
            slopes[own + 3, k, j, i] = sign * inside * row * light


def _prior(pair: Pair, shape: Shape, others: int) -> tuple[Floats, Floats] | None:
    """Return what is known of the parameters beforehand: of the shift by the light's motion."""
    if pair.motion is None and shape.prior is None:
        return None
    mean, known = shape.prior or (np.zeros(shape.lower.size), np.zeros(shape.lower.size))
    shift, certain = np.zeros(2), 0.0
    if pair.motion is not None:
        shift, certain = BEFORE * pair.motion.flash, pair.motion.deviation**-2
    nothing = np.zeros(others)
    return (
        np.concatenate([mean, shift, nothing]),
        np.concatenate([known, [certain, certain], nothing]),
    )


def joined(*sentences: str) -> str:
    """Return what there is to be said, of several sentences that may be empty."""
    return '; '.join(filter(None, sentences))
