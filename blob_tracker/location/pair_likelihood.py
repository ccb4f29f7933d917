"""Models of a lit and an unlit window together: their likelihood, and the climb to its top."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.hypotheses import Pair
from blob_tracker.location.normal_equations import NormalEquations, solve
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Model = Callable[[Floats, Floats, Floats], None]  # theta, means to fill in, slopes to fill in

STEPS = 40
CONVERGED = 1e-3  # gain in log-likelihood still to be had
STIFFEST = 1e8  # damping: there is no way up
# Variance of the texture over that of an unlit pixel, among which the likeliest is taken.
TEXTURES = np.concatenate([[0.0], np.geomspace(0.05, 2000.0, 14)])


@dataclass(frozen=True)
class Optimum:
    """
    The top of a model's likelihood.

    Parameters
    ----------
    theta : (p,) array
        Parameters.
    covariance : (p, p) array
        Inverse of their Fisher information.
    log_likelihood : float
        Of the pixels, without the constant of the normal distribution.
    texture : float
        Variance of what is common to both windows, DN^2.
    chi2 : float
        Squared residuals over their variance, per degree of freedom.
    means : (k, h, w) array
        Of the pixels, DN.
    parameters : int
        How many were fitted, the texture's variance among them.

    """

    theta: Floats
    covariance: Floats
    log_likelihood: float
    texture: float
    chi2: float
    means: Floats
    parameters: int


@kernel
def log_likelihood(
    pixels: Array, means: Array, usable: NDArray[np.bool_], shot: float, floor: float,
    texture: float,
) -> tuple[float, float]:
    """
    Return ln L of a pair's pixels, and the squares that are in it.

    What is behind the target is in both windows: a pixel's two residuals have the variances
    V_1 + T and V_2 + T and the covariance T. With p = 1 / V the inverse of that matrix is
    diag(p) - T p p^T / (1 + T (p_1 + p_2)) and its determinant (1 + T (p_1 + p_2)) / (p_1 p_2).
    """
    windows, height, width = pixels.shape
    squares, logarithms = 0.0, 0.0
    for j in range(height):
        product = 1.0
        for i in range(width):
            shared, both = 1.0, 0.0
            for k in range(windows):
                if usable[k, j, i]:
                    variance = max(means[k, j, i], 0.0) * shot + floor
                    residual = pixels[k, j, i] - means[k, j, i]
                    product *= variance
                    shared += texture / variance
                    both += residual / variance
                    squares += residual * residual / variance
            squares -= texture * both * both / shared
            product *= shared
            # One logarithm serves several pixels.
            if i % 4 == 3 or i == width - 1:
                logarithms += math.log(product)
                product = 1.0
    return -0.5 * (squares + logarithms), squares


@kernel
def likeliest_texture(
    pixels: Array, means: Array, usable: NDArray[np.bool_], shot: float, floor: float,
    textures: Array,
) -> float:
    """
    Return the variance of the texture under which the pixels are likeliest, DN^2.

    `textures` are those that are tried, over the variance of the darkest pixel.
    """
    if pixels.shape[0] < 2:
        return 0.0
    unit = max(means.min(), 0.0) * shot + floor
    best, found = -math.inf, 0.0
    for texture in textures:
        value, _ = log_likelihood(pixels, means, usable, shot, floor, texture * unit)
        if value > best:
            best, found = value, texture * unit
        else:
            break  # the likelihood has one top
    return found


def log_likelihood_of(pair: Pair, means: Floats) -> float:
    """Return ln L of a pair with these (k, h, w) means, DN, under its likeliest texture."""
    noise = pair.noise
    told = pair.pixels, means, pair.usable, 1.0 / noise.gain, noise.read_noise**2 + 1.0 / 12.0
    return float(log_likelihood(*told, likeliest_texture(*told, TEXTURES))[0])


@kernel
def fill_equations(
    pixels: Array, means: Array, slopes: Array, usable: NDArray[np.bool_], shot: float,
    floor: float, texture: float, score: Array, fisher: Array,
) -> None:
    """
    Fill the (p,) score and the (p, p) Fisher information.

    With s the slopes of a pixel's two means, the weights 1 / V = w and the matrix of
    `log_likelihood` it is s^T (diag(w) - T w w^T / (1 + T (w_1 + w_2))) s: the texture takes off
    each window's slopes the mean of both, T / (1 + T (w_1 + w_2)) of the sum of w s.
    """
    count, windows, height, width = slopes.shape
    size = height * width
    weight, residual = np.zeros((windows, size)), np.zeros((windows, size))
    part = np.empty(size)
    for n in range(size):
        j, i = n // width, n % width
        shared, both = 1.0, 0.0
        for k in range(windows):
            if usable[k, j, i]:
                weight[k, n] = 1.0 / (max(means[k, j, i], 0.0) * shot + floor)
                residual[k, n] = weight[k, n] * (pixels[k, j, i] - means[k, j, i])
                shared += texture * weight[k, n]
                both += residual[k, n]
        part[n] = texture / shared
        for k in range(windows):
            residual[k, n] -= part[n] * weight[k, n] * both
    flat = slopes.reshape(count, windows, size)
    pull, mean = np.empty((windows, size)), np.empty(size)
    for p in range(count):
        mean[:] = 0.0
        if texture > 0.0:
            for k in range(windows):
                for n in range(size):
                    mean[n] += part[n] * weight[k, n] * flat[p, k, n]
        total = 0.0
        for k in range(windows):
            for n in range(size):
                pull[k, n] = weight[k, n] * (flat[p, k, n] - mean[n])
                total += flat[p, k, n] * residual[k, n]
        score[p] = total
        for q in range(p + 1):
            total = 0.0
            for k in range(windows):
                for n in range(size):
                    total += pull[k, n] * flat[q, k, n]
            fisher[p, q] = total
            fisher[q, p] = total


class Climb(NamedTuple):
    """
    Where a climb is; memory that its steps change.

    Parameters
    ----------
    theta, ahead, lower, upper : (p,) arrays
        Where it stands, what it tries next, and the bounds.
    score, fisher : (p,) and (p, p) arrays
        Where it stands.
    mean, known : (p,) arrays
        What is known of the parameters beforehand, and the inverse of its variance.
    numbers : (5,) array
        Log-likelihood, squares, damping, texture, and the gain that the step promises.
    equations : NormalEquations
        Of the parameters that are not held at a bound.

    """

    theta: Array
    ahead: Array
    lower: Array
    upper: Array
    score: Array
    fisher: Array
    mean: Array
    known: Array
    numbers: Array
    equations: NormalEquations


@kernel
def _step(
    state: Climb, pixels: Array, means: Array, slopes: Array, usable: NDArray[np.bool_],
    shot: float, floor: float, textures: Array, first: bool,
) -> bool:
    """Stand where the likelihood is higher, and step ahead; False at the top, or if stuck."""
    theta, ahead, lower, upper, score, fisher, prior, known, numbers, equations = state
    count = theta.size
    surprise = 0.0
    for p in range(count):
        surprise += 0.5 * known[p] * (ahead[p] - prior[p]) ** 2
    value, squares = log_likelihood(pixels, means, usable, shot, floor, numbers[3])
    value -= surprise
    promised = numbers[4]
    if first or value >= numbers[0]:
        theta[:] = ahead
        texture = likeliest_texture(pixels, means, usable, shot, floor, textures)
        moved = texture != numbers[3]
        if moved:
            value, squares = log_likelihood(pixels, means, usable, shot, floor, texture)
            value -= surprise
        numbers[0], numbers[1], numbers[3] = value, squares, texture
        fill_equations(
            pixels, means, slopes, usable, shot, floor, texture, score, fisher
        )
        for p in range(count):
            score[p] += known[p] * (prior[p] - theta[p])
            fisher[p, p] += known[p]
        numbers[2] *= 0.2
        if not first and not moved and promised < CONVERGED:
            return False
    else:
        # The root of the score is not quite the top, as the variance moves with the mean.
        if promised < CONVERGED or (promised < 0.1 and numbers[2] > 1e3):
            return False
        numbers[2] *= 8.0
    matrix, right, _, solution = equations
    while numbers[2] < STIFFEST:
        free = 0
        for p in range(count):
            if _is_free(state, p):
                column = 0
                for q in range(p + 1):
                    if _is_free(state, q):
                        matrix[free, column] = fisher[p, q]
                        column += 1
                right[free] = score[p]
                free += 1
        if solve(equations, free, numbers[2]):
            break
        numbers[2] = max(10.0 * numbers[2], 1e-6)
    column = 0
    numbers[4] = 0.0
    for p in range(count):
        ahead[p] = theta[p]
        if _is_free(state, p):
            ahead[p] = min(max(theta[p] + solution[column], lower[p]), upper[p])
            column += 1
            numbers[4] += 0.5 * score[p] * (ahead[p] - theta[p])
    return bool(numbers[2] < STIFFEST)


@kernel
def _is_free(state: Climb, p: int) -> bool:
    """Return False for a parameter at its bound that is pushed outward, or that has no effect."""
    if state.fisher[p, p] <= 0.0 or state.lower[p] == state.upper[p]:
        return False
    if state.theta[p] <= state.lower[p]:
        return bool(state.score[p] > 0.0)
    return bool(state.theta[p] < state.upper[p] or state.score[p] < 0.0)


def climb(
    pair: Pair,
    model: Model,
    start: Floats,
    lower: Floats,
    upper: Floats,
    prior: tuple[Floats, Floats] | None = None,
    steps: int = STEPS,
) -> Optimum | None:
    """
    Climb the likelihood of a model with damped Fisher scoring; None if there is no top.

    Parameters
    ----------
    pair : Pair
        The pixels.
    model : callable
        Fills the (k, h, w) means of a (p,) theta and their (p, k, h, w) slopes.
    start, lower, upper : (p,) arrays
        First guess, and what the parameters are held between.
    prior : two (p,) arrays, optional
        What is known of them beforehand, and the inverse of its variance.
    steps : int
        After which there is no top.

    """
    noise, pixels, usable = pair.noise, pair.pixels, pair.usable
    shot, floor = 1.0 / noise.gain, noise.read_noise**2 + 1.0 / 12.0
    count = start.size
    means, slopes = np.zeros(pixels.shape), np.zeros((count, *pixels.shape))
    state = Climb(
        np.empty(count), np.clip(start, lower, upper), lower, upper, np.empty(count),
        np.empty((count, count)), *(prior or (np.zeros(count), np.zeros(count))),
        np.array([-math.inf, 0.0, 5e-3, 0.0, 0.0]),
        NormalEquations(
            np.empty((count, count)), np.empty(count), np.empty((count, count)), np.empty(count)
        ),
    )
    for step in range(steps):
        model(state.ahead, means, slopes)
        if not _step(state, pixels, means, slopes, usable, shot, floor, TEXTURES, step == 0):
            break
    theta, fisher = state.theta, state.fisher
    value, squares, damping, texture, _ = state.numbers
    if step == steps - 1 or damping >= STIFFEST or not math.isfinite(value):
        return None
    # What is at a bound is known to be there.
    inner = (theta > lower) & (theta < upper) & (np.diag(fisher) > 0.0)
    covariance = np.zeros_like(fisher)
    scale = np.sqrt(np.diag(fisher)[inner])
    try:
        known = fisher[np.ix_(inner, inner)] / np.outer(scale, scale)
        root = np.linalg.inv(np.linalg.cholesky(known))
    except np.linalg.LinAlgError:
        return None
    covariance[np.ix_(inner, inner)] = root.T @ root / np.outer(scale, scale)
    if not (np.diag(covariance)[inner] > 0.0).all():
        return None  # rounding is all that tells two parameters apart
    model(theta, means, slopes)
    freedom = int(usable.sum()) - int(inner.sum())
    return Optimum(
        theta, covariance, float(value), float(texture), squares / max(freedom, 1), means,
        int(inner.sum()) + int(texture > 0.0),
    )
