"""What is left when the best model is taken off a window, and what it means for the place."""

from __future__ import annotations

from dataclasses import dataclass, replace
import math

from blob_tracker.kernel import Array
from blob_tracker.location.hypotheses import Fit, Pair
from blob_tracker.location.pair_likelihood import fill_equations, Floats, Model, Optimum
from blob_tracker.location.pair_model import AMPLITUDE, BACKGROUND, fill_one_pulse, to_fit, X, Y
from blob_tracker.location.scoring import COVARIANCE_INFLATION
import numpy as np

ODD_PIXELS = 5.0  # standard deviations of chi2, as in `suspicion`
ALIKE = 4.0  # standard deviations of the correlation of neighbours: beyond it they are alike
LOPSIDED = 13.8  # chi-square of two degrees of freedom that noise exceeds once in 1000
WARNED = 1.5  # chi2 of white residuals, from which on they are spoken of
LOPSIDED_LIGHT = (
    'misfit: the light is lopsided: a tail, or a second light beside it, moves its position: '
    'learn its pulse (calibrate pulse)'
)
_LEVELS = (AMPLITUDE, BACKGROUND)
STEP = 0.05  # standard deviations of a parameter, over which the slope of the score is taken
FEWEST = 6  # pixels that have a mirror image in the window


@dataclass(frozen=True)
class Remainder:
    """
    The residuals of a window's lit pixels.

    Parameters
    ----------
    chi2 : float
        Their squares over their variance, per degree of freedom.
    odd : float
        The same of their odd part about the pulse's centre.
    neighbours : float
        Correlation of neighbours in standard deviations of that of noise.
    shift : (2,) array
        By which the pulse's core alone lies off the whole of it, px.
    lopsided : float
        Its square over its variance: a chi-square of two degrees of freedom in noise.
    significant : bool
        Whether chi2 is more than noise makes of it.

    """

    chi2: float
    odd: float
    neighbours: float
    shift: Floats
    lopsided: float
    significant: bool

    @property
    def structured(self) -> bool:
        """Whether the model is wrong, and not the noise."""
        return self.significant and self.neighbours > ALIKE


def remainder(pair: Pair, optimum: Optimum, slopes: Floats) -> Remainder:
    """
    Return what a fit leaves of the lit pixels.

    A misfit that is even about the centre, of a disc say, does not move it. What is odd does:
    white noise and a random texture have as much of the one as of the other, a tail more of the
    odd. The core, the nearer half of the information on the place, and the wings agree on it
    where the light is even.
    """
    noise = pair.noise
    variance = np.maximum(optimum.means, 0.0) / noise.gain + noise.read_noise**2 + 1.0 / 12.0
    residual, spread = pair.lit - optimum.means[0], variance[0] + optimum.texture
    usable = pair.usable[0]
    if pair.unlit is not None and optimum.texture > 0.0:
        # What the unlit pixel says of the texture is taken off.
        told = np.where(pair.usable[1], optimum.texture / (variance[1] + optimum.texture), 0.0)
        residual = residual - told * (pair.unlit - optimum.means[1])
        spread = spread - told * optimum.texture
    whitened = np.where(usable, residual / np.sqrt(spread), 0.0)
    freedom = max(int(usable.sum()) - optimum.parameters, 1)
    chi2 = float((whitened**2).sum()) / freedom
    pairs = [(whitened[1:], whitened[:-1]), (whitened[:, 1:], whitened[:, :-1])]
    product = sum(float((a * b).sum()) for a, b in pairs)
    count = sum(a.size for a, _ in pairs)
    neighbours = product / max(float((whitened**2).mean()), 1e-12) / math.sqrt(count)
    shift, lopsided = _core_shift(optimum, residual, np.where(usable, 1.0 / spread, 0.0), slopes)
    return Remainder(
        chi2, chi2 * _odd_part(whitened, optimum.theta[X], optimum.theta[Y]), neighbours, shift,
        lopsided, chi2 > 1.0 + ODD_PIXELS * math.sqrt(2.0 / freedom),
    )


def _odd_part(whitened: Floats, x: float, y: float) -> float:
    """Return the power of what is odd about a place over that of what is even and odd, doubled."""
    mirrored = _mirror(_mirror(whitened, y).T, x).T
    both = ~np.isnan(mirrored)
    if both.sum() < FEWEST:
        return 1.0
    odd = float(((whitened - mirrored)[both] ** 2).sum())
    even = float(((whitened + mirrored)[both] ** 2).sum())
    return 2.0 * odd / max(odd + even, 1e-12)


def _mirror(rows: Floats, centre: float) -> Floats:
    """Return rows at their places mirrored about a centre, NaN if there is none (cubic)."""
    places = 2.0 * centre - np.arange(rows.shape[0])
    first = np.floor(places).astype(int) - 1
    t = float(places[0] - math.floor(places[0]))
    weights = 0.5 * np.array([
        -t + 2.0 * t**2 - t**3, 2.0 - 5.0 * t**2 + 3.0 * t**3, t + 4.0 * t**2 - 3.0 * t**3,
        t**3 - t**2,
    ])  # of Catmull and Rom
    out = np.zeros(rows.shape)
    last = rows.shape[0] - 1
    for k, weight in enumerate(weights):
        out += weight * rows[np.clip(first + k, 0, last)]
    out[(places < 0.0) | (places > last)] = np.nan
    return out


def _core_shift(
    optimum: Optimum, residual: Floats, weight: Floats, slopes: Floats
) -> tuple[Floats, float]:
    """Return how far the core is off the whole, px, and its square over its variance."""
    by_place = slopes[[X, Y], 0]
    told = weight * (by_place**2).sum(axis=0)
    rows, columns = np.indices(residual.shape)
    distance = np.hypot(columns - optimum.theta[X], rows - optimum.theta[Y])
    order = np.argsort(distance, axis=None, kind='stable')
    total = np.cumsum(told.ravel()[order])
    core = distance <= distance.ravel()[order[int(np.searchsorted(total, 0.5 * total[-1]))]]
    parts = []
    for part in (core, ~core):
        inside = np.where(part, weight, 0.0)
        fisher = np.einsum('pji,qji,ji->pq', by_place, by_place, inside)
        score = np.einsum('pji,ji,ji->p', by_place, residual, inside)
        try:
            parts.append((np.linalg.inv(fisher), score))
        except np.linalg.LinAlgError:
            return np.zeros(2), 0.0
    (inner, pull), (outer, push) = parts
    # Half of their distance: the whole is in the middle of them.
    shift = 0.5 * (inner @ pull - outer @ push)
    try:
        lopsided = float(shift @ np.linalg.solve(0.25 * (inner + outer), shift))
    except np.linalg.LinAlgError:
        return np.zeros(2), 0.0
    return shift, lopsided


def sandwich(pair: Pair, optimum: Optimum, model: Model) -> Floats:
    r"""
    Return the covariance of the likeliest parameters of a model that is not the true one.

        C = H^-1 J H^-1,    J = sum_kl W s_k s_l W Cov(z_k, z_l),    H = -dU / dtheta

    with the slopes s, the score U and the weights W (White, Econometrica 50 (1982), theorem
    3.2). The pixels' variance is that of their own light. What is at a bound has none.
    """
    theta, noise, pixels, usable = optimum.theta, pair.noise, pair.pixels, pair.usable
    shot, floor = 1.0 / noise.gain, noise.read_noise**2 + 1.0 / 12.0
    inner = np.flatnonzero(np.diag(optimum.covariance) > 0.0)
    means, slopes = np.zeros(pixels.shape), np.zeros((theta.size, *pixels.shape))
    fisher = np.zeros((theta.size, theta.size))

    def score(place: Floats) -> Floats:
        model(place, means, slopes)
        out: Array = np.zeros(theta.size)
        fill_equations(
            pixels, means, slopes, usable, shot, floor, optimum.texture, out, fisher
        )
        return out

    steps = STEP * np.sqrt(np.diag(optimum.covariance))
    hessian = np.zeros((theta.size, theta.size))
    for p in inner:
        step = np.zeros(theta.size)
        step[p] = steps[p]
        hessian[p] = (score(theta - step) - score(theta + step)) / (2.0 * steps[p])
    score(theta)
    # Of the two residuals of a pixel: their weights' matrix, as in `pair_likelihood`.
    single = np.where(usable, 1.0 / (np.maximum(means, 0.0) * shot + floor), 0.0)
    shared = 1.0 + optimum.texture * single.sum(axis=0)
    pull = single * slopes
    pull = pull - optimum.texture * single * pull.sum(axis=1, keepdims=True) / shared
    variance = np.maximum(pixels, 0.0) * shot + floor
    common = pull.sum(axis=1)
    spread = np.einsum('pkji,qkji,kji->pq', pull, pull, np.where(usable, variance, 0.0))
    spread += optimum.texture * np.einsum('pji,qji->pq', common, common)
    picked = np.ix_(inner, inner)
    hessian = 0.5 * (hessian + hessian.T)[picked]
    covariance = np.zeros((theta.size, theta.size))
    scale = np.sqrt(np.diag(optimum.covariance))[inner]
    # In standard deviations: of a model that is nearly true it is the identity.
    values, vectors = np.linalg.eigh(hessian * np.outer(scale, scale))
    if values.min() <= 0.0:
        return optimum.covariance
    inverse = (vectors / values) @ vectors.T * np.outer(scale, scale)
    covariance[picked] = inverse @ spread[picked] @ inverse
    return covariance


def doubted(
    pair: Pair, optimum: Optimum, model: Model, warning: str = ''
) -> tuple[Fit, Remainder]:
    """
    Return the fit of a model, with what its misfit does to the place in its covariance.

    The covariance of a true model is that of the likelihood. Where chi2 says that the model is
    not true it is that of `sandwich`, times chi2 where the residuals are white, and times their
    odd part's where they are not. Where the
    core is off the whole its shift is added: the light's place is in the one or in the other.
    """
    slopes = np.zeros((optimum.theta.size, *pair.pixels.shape))
    model(optimum.theta, np.zeros(pair.pixels.shape), slopes)
    left = remainder(pair, optimum, slopes)
    fit = replace(
        to_fit(pair, optimum, warning), chi2=left.chi2,
        covariance=_inflation(optimum) * optimum.covariance[:2, :2],
    )
    if not left.significant and left.lopsided < LOPSIDED:
        return fit, left
    grown = fit.covariance
    if left.significant:
        # What is white scatters the place as it does the pixels.
        scale = max(left.odd, 1.0) if left.structured else left.chi2
        grown = scale * _inflation(optimum) * sandwich(pair, optimum, model)[:2, :2]
    if left.lopsided > LOPSIDED:
        grown = grown + (1.0 - 2.0 / left.lopsided) * np.outer(left.shift, left.shift)
    if left.significant and pair.clipped:
        # Charge that runs, or glare: whatever the shape seems to be.
        fit = replace(fit, warning=_in_words(pair, left))
    return replace(fit, covariance=grown, misfit=left.significant), left


def _inflation(optimum: Optimum) -> float:
    """Return by how much the covariance of a faint light is too small, as `maximum_likelihood`."""
    told = np.linalg.pinv(optimum.covariance)[np.ix_(_LEVELS, _LEVELS)]
    # Of the amplitude in its shape: what else changes with it says nothing of how faint it is.
    known = told[0, 0] - told[0, 1] ** 2 / max(told[1, 1], 1e-300)
    detection = optimum.theta[AMPLITUDE] ** 2 * max(float(known), 1e-12)
    return float(1.0 + COVARIANCE_INFLATION / max(detection, COVARIANCE_INFLATION))


def misfitting(pair: Pair, optimum: Optimum) -> Fit | None:
    """Return the round pulse that no alternative outdoes, and what is wrong with it."""
    fit, left = doubted(pair, optimum, fill_one_pulse)
    if not left.significant:
        return None
    return replace(fit, warning=_in_words(pair, left))


def _in_words(pair: Pair, left: Remainder) -> str:
    """Say what kind of misfit it is."""
    much = f'chi2 {left.chi2:.1f}'
    clipped = pair.pitch**2 * pair.clipped
    if not left.structured and not clipped:
        if left.chi2 < WARNED:
            return ''
        return (
            f'misfit ({much}) of noise, not of shape: the pixels scatter more than gain and '
            'read_noise say: calibrate noise'
        )
    if clipped:
        many = 'up to ' if pair.pitch > 1 else ''
        pixels = 'pixel is' if clipped == 1 else 'pixels are'
        return f'misfit ({much}): {many}{clipped} {pixels} clipped: lower the exposure'
    if left.lopsided > LOPSIDED:
        return (
            f'misfit ({much}): the light is lopsided: a tail, or a second light beside it, may '
            f'move its position by {pair.pitch * np.hypot(*left.shift):.2f} px: learn its pulse '
            '(calibrate pulse)'
        )
    return (
        f'misfit ({much}): the light is not a Gaussian, but symmetric about its position: learn '
        'its pulse (calibrate pulse)'
    )
