"""Pulses of light on pixels, where they go, and the numbers that a camera makes of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from benchmarks.world.situation import (
    BACKGROUND, Floats, FULL_SCALE, HEIGHT, Model, NOISE, PEAK, SHAPE, Shot, SIGMA, WIDTH,
)
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erf, erfc

CENTRE = np.array([WIDTH / 2, HEIGHT / 2])  # px
JITTER = 1.0  # px to either side: all phases, also those of a colour filter of 2 x 2 pixels
OVERSAMPLING = 8  # points a pixel and axis
RADIUS = 25.0  # px, of the circle that a moving light goes round: all directions come by
MARGIN = 5.0  # sigma beyond which a soft edge is over

Develop = Callable[[Floats, np.random.Generator], Pixels]


def gaussians(
    shape: tuple[int, int], x: ArrayLike, y: ArrayLike, sigma: ArrayLike, weight: ArrayLike = 1.0
) -> Floats:
    """
    Return the sum of Gaussians, the mean over each pixel.

    Parameters
    ----------
    shape : (int, int)
        Height and width, px.
    x, y, sigma : float or (n,) arrays
        Centres and standard deviations, px.
    weight : float or (n,) array
        Peak of each one.

    Returns
    -------
    (h, w) array
        sum_n w_n E(k; x_n) E(l; y_n) with the mean E of a Gaussian over a pixel,
        E(k; x) = sqrt(pi/2) sigma [erf((k + 1/2 - x) / sqrt2 sigma) - erf((k - 1/2 - x) / ...)].

    """
    x, y, sigma, weight = np.broadcast_arrays(*map(np.atleast_1d, (x, y, sigma, weight)))

    def profile(count: int, centre: Floats) -> Floats:
        edges = (np.arange(count + 1) - 0.5 - centre[:, None]) / (np.sqrt(2) * sigma[:, None])
        return np.asarray(np.sqrt(np.pi / 2) * sigma[:, None] * np.diff(erf(edges), axis=1))

    return np.asarray((weight[:, None] * profile(shape[0], y)).T @ profile(shape[1], x))


def oversampled(
    shape: tuple[int, int],
    x: float,
    y: float,
    reach: float,
    intensity: Callable[[Floats, Floats], Floats],
) -> Floats:
    """
    Return the mean of any intensity over each pixel, by 8 x 8 points in each.

    Parameters
    ----------
    shape : (int, int)
        Height and width, px.
    x, y : float
        Centre, px.
    reach : float
        Distance beyond which there is no light, px.
    intensity : callable
        (u, v) px from the centre -> intensity; smooth over an eighth of a pixel.

    """
    left, top = max(int(x - reach), 0), max(int(y - reach), 0)
    right, bottom = min(int(x + reach) + 2, shape[1]), min(int(y + reach) + 2, shape[0])
    wide, high = right - left, bottom - top
    fine = (np.arange(OVERSAMPLING) + 0.5) / OVERSAMPLING - 0.5
    u = (np.arange(left, right)[:, None] + fine).ravel() - x
    v = (np.arange(top, bottom)[:, None] + fine).ravel() - y
    points = intensity(u[None, :], v[:, None])
    out = np.zeros(shape)
    out[top:bottom, left:right] = points.reshape(high, OVERSAMPLING, wide, OVERSAMPLING).mean(
        axis=(1, 3)
    )
    return out


def ring(
    shape: tuple[int, int], x: float, y: float, radius: float, hole: float, edge: float
) -> Floats:
    """
    Return a disc of unit intensity, or a ring, with soft edges: a light out of focus.

    Parameters
    ----------
    shape : (int, int)
        Height and width, px.
    x, y : float
        Centre, px.
    radius : float
        Outer radius, px.
    hole : float
        Inner radius over the outer one; 0 for a disc.
    edge : float
        Standard deviation of the blur of the edges, px.

    """
    scale = np.sqrt(2) * edge

    def intensity(u: Floats, v: Floats) -> Floats:
        distance = np.hypot(u, v)
        light = 0.5 * erfc((distance - radius) / scale)
        if hole > 0.0:
            light = light - 0.5 * erfc((distance - hole * radius) / scale)
        return np.asarray(light)

    return oversampled(shape, x, y, radius + MARGIN * edge, intensity)


def spot(parameters: Floats) -> Floats:
    """Return the plain model: x, y, peak, sigma, background."""
    x, y, peak, sigma, background = parameters
    return gaussians(SHAPE, x, y, sigma, peak) + background


def plain(x: float, y: float, peak: float = PEAK, sigma: float = SIGMA) -> Model:
    """Return the plain model of a light at a place."""
    return Model(spot, np.array([x, y, peak, sigma, BACKGROUND]))


def resting(
    count: int, random: np.random.Generator, shape: tuple[int, int] = SHAPE
) -> Floats:
    """
    Return (count, 2) px: a place anew for each lit frame and the unlit one before it.

    In all sub-pixel phases. The even frames are lit.
    """
    middle = np.array([shape[1] / 2, shape[0] / 2])
    pairs = middle + random.uniform(-JITTER, JITTER, (count // 2 + 1, 2))
    return np.asarray(np.repeat(pairs, 2, axis=0)[1:count + 1])


def circling(count: int, random: np.random.Generator, speed: float) -> Floats:
    """Return (count, 2) px: places on a circle, `speed` px a frame."""
    angle = random.uniform(0.0, 2.0 * np.pi) + np.arange(count) * speed / RADIUS
    return CENTRE + RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def digitised(mean: Floats, random: np.random.Generator) -> Pixels:
    """Return pixels with shot and read noise, 8 bit."""
    return expose(mean, NOISE, random, saturation=FULL_SCALE)


def flashing(
    count: int,
    random: np.random.Generator,
    light: Callable[[float, float], Model],
    *,
    places: Floats | None = None,
    develop: Develop = digitised,
    unlit: float = BACKGROUND,
    shape: tuple[int, int] = SHAPE,
) -> Iterator[Shot]:
    """
    Yield shots of a light that is on in every other frame, and dark in the others.

    Parameters
    ----------
    count : int
        Frames.
    random : Generator
        Of places and noise.
    light : callable
        (x, y) px -> model of the lit frame.
    places : (count, 2) array, optional
        Of the light, px; that of `resting` where it is left out.
    develop : callable
        (mean, random) -> pixels.
    unlit : float
        Mean of the dark frames, DN.
    shape : (int, int)
        Height and width of the frames, px.

    """
    dark = np.full(shape, unlit)
    if places is None:
        places = resting(count, random, shape)
    for index, (x, y) in enumerate(places):
        if index % 2:
            yield Shot(develop(dark, random), False)
        else:
            model = light(x, y)
            yield Shot(develop(model.mean(model.parameters), random), True, x, y, model=model)


def smooth_field(
    shape: tuple[int, int], correlation: float, random: np.random.Generator
) -> Floats:
    """
    Return a random field of mean 0 and standard deviation 1 that goes on beyond its edges.

    White noise times exp(-2 (pi f c)^2): correlated over `correlation` px, as with a Gaussian of
    that sigma laid over it.
    """
    f = np.hypot(np.fft.fftfreq(shape[0])[:, None], np.fft.fftfreq(shape[1])[None, :])
    grain = np.fft.fft2(random.standard_normal(shape))
    field = np.fft.ifft2(grain * np.exp(-2.0 * (np.pi * f * correlation) ** 2)).real
    return np.asarray((field - field.mean()) / field.std())
