"""A light of any shape that is in the unlit window as well: fainter, and where it was then."""

from __future__ import annotations

from dataclasses import dataclass, replace

from blob_tracker.location.hypotheses import FALSE_ALARM, Pair
from blob_tracker.location.pair_likelihood import climb, Floats, Model, Optimum
from blob_tracker.location.pair_model import BACKGROUND, brightest, X, Y
from blob_tracker.location.unlit_pulse import outdoes_texture
import numpy as np

BEFORE = -0.5  # of a flash's displacement: the unlit frame is halfway to the last lit one
BRIGHTER = 1.0  # than the lit light: such a one in the unlit frame is another one
UNDECIDED = 12.0  # of twice the log-likelihood, below which a ghost is likelier beforehand
STEPS = 80
ADDED = 3  # parameters: the shift in x and y, and the share that is left
NOTHING = np.zeros(ADDED)
STILL_ON = (
    'the light is still on in the unlit frame ({:.0f} % of it): shorten the exposure, shift the '
    "flash's phase or flash at half the rate"
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
    lower, upper : (p,) arrays
        What its parameters are held between.
    prior : two (p,) arrays, optional
        As in `climb`.
    warning : str
        That it is in the unlit window, too; '' where it is not.

    """

    optimum: Optimum
    model: Model
    lower: Floats
    upper: Floats
    prior: tuple[Floats, Floats] | None = None
    warning: str = ''


def with_ghost(pair: Pair, shape: Shape) -> Shape:
    """
    Return the shape with what is left of it in the unlit window, where that is shown to be.

        lit = b + S(x),    unlit = b + g S(x + s)

    Or, where that is clearly likelier, a lamp of that shape behind the light, in both windows:
    lit = b + S(x) + g S(x + s).
    """
    if pair.unlit is None or not pair.haunted:
        return shape
    ghost, lamp = (_fit(pair, shape, in_lit) for in_lit in (0.0, 1.0))
    best = ghost
    if lamp is not None and (ghost is None or _gain(lamp, ghost) > UNDECIDED):
        best = lamp
    fixed, each = FALSE_ALARM
    if best is None or _gain(best, shape) < fixed + each * ADDED:
        return shape
    return best if outdoes_texture(pair, best.optimum) else shape


def _gain(shape: Shape, other: Shape) -> float:
    """Return twice the log-likelihood of a shape over that of another one."""
    return 2.0 * (shape.optimum.log_likelihood - other.optimum.log_likelihood)


def _fit(pair: Pair, shape: Shape, in_lit: float) -> Shape | None:
    """Fit the shape and its ghost, of which such a share is in the lit window."""
    assert pair.unlit is not None
    # What is in the unlit window has drawn the fit of both away from the lit light.
    alone = climb(
        replace(pair, unlit=None), shape.model, shape.optimum.theta, shape.lower, shape.upper,
        shape.prior, steps=STEPS,
    )
    theta, means = (alone or shape.optimum).theta, (alone or shape.optimum).means[0]
    x, y = brightest(pair.unlit)
    light = float(means.max()) - theta[BACKGROUND]
    left = float(pair.unlit[int(y), int(x)]) - float(np.median(pair.unlit))
    # Its brightest place, as the shape's may be off its middle.
    lit_x, lit_y = brightest(means)
    height, width = means.shape
    prior = _prior(pair, shape)
    lower = np.append(shape.lower, [-width, -height, 0.0])
    upper = np.append(shape.upper, [width, height, BRIGHTER])
    model = _in_both(shape.model, in_lit)
    best = None
    for shift in _first_shifts(pair, np.array([x - lit_x, y - lit_y])):
        start = np.append(theta, [*shift, min(max(left / max(light, 1.0), 0.01), BRIGHTER)])
        found = climb(pair, model, start, lower, upper, prior, steps=STEPS)
        if found is not None and (
            best is None or found.log_likelihood > best.log_likelihood
        ):
            best = found
    if best is None:
        return None
    warning = '' if in_lit else STILL_ON.format(100.0 * best.theta[-1])
    return Shape(best, model, lower, upper, prior, warning)


def _first_shifts(pair: Pair, seen: Floats) -> list[Floats]:
    """Return where the ghost may be: by its brightest pixels, and by the light's motion."""
    if pair.motion is None:
        return [seen, np.zeros(2)]
    return [seen, BEFORE * pair.motion.flash]


def _in_both(model: Model, in_lit: float) -> Model:
    """Return the model of a shape in both windows; its last parameters are shift and share."""
    def fill(theta: Floats, means: Floats, slopes: Floats) -> None:
        own = theta.size - ADDED
        shift, share = theta[own:own + 2], theta[-1]
        model(theta[:own], means, slopes[:own])
        slopes[own:] = 0.0
        there = theta[:own].copy()
        there[[X, Y]] += shift
        left, by = np.zeros(means.shape), np.zeros((own, *means.shape))
        model(there, left, by)
        light = left[0] - theta[BACKGROUND]
        by[BACKGROUND] = 0.0
        for k, part in ((0, in_lit), (1, 1.0)):
            if part == 0.0:
                continue
            means[k] += part * share * light
            slopes[:own, k] += part * share * by[:, 0]
            slopes[own:own + 2, k] = part * share * by[[X, Y], 0]
            slopes[-1, k] = part * light

    return fill


def _prior(pair: Pair, shape: Shape) -> tuple[Floats, Floats] | None:
    """Return what is known of the parameters beforehand: of the shift by the light's motion."""
    mean, known = shape.prior or (np.zeros(shape.lower.size), np.zeros(shape.lower.size))
    motion = pair.motion
    if motion is None:
        return None if shape.prior is None else (np.append(mean, NOTHING), np.append(known, NOTHING))
    certain = 1.0 / motion.deviation**2
    return (
        np.append(mean, [*(BEFORE * motion.flash), 0.0]), np.append(known, [certain, certain, 0.0])
    )


def joined(*sentences: str) -> str:
    """Return what there is to be said, of several sentences that may be empty."""
    return '; '.join(filter(None, sentences))
