"""How a light moves in the picture: Singer's model, in pixels and frame intervals."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel

STATE = 6  # x, y, their velocities, their accelerations
MANOEUVRE = 15.0  # frame intervals for which an acceleration lasts
STILL = 0.05  # px a frame interval squared: acceleration of what hardly moves
REACH = 150.0  # px: a path of this reach at the speed v has accelerations of v^2 / REACH
# Of the variance of its manoeuvres, what a light makes use of: it is learned
CALMEST, LEARNED = 1 / 64, 0.1
MOST_SURPRISE = 10.0  # times what the covariance allows for


@kernel
def manoeuvre(vx: float, vy: float, ax: float, ay: float) -> float:
    """
    Return the variance of the acceleration along an axis, of a light that moves so.

    On its way back and forth a light is fast where it is not accelerated, and slow where it is.
    """
    return STILL**2 + ((vx * vx + vy * vy) / REACH) ** 2 + ax * ax + ay * ay


@kernel
def predict(state: Array, covariance: Array, dt: float, agility: float, work: Array) -> None:
    """
    Move a light on by dt.

    Per axis x, v, a with a' = -a / T + w (Singer, IEEE Trans. AES 6 (1970)), to the first order
    in dt / T but for the decay of a; w of the density 2 sigma_a^2 / T, where sigma_a grows with
    the square of the speed (what is quick turns in as much room as what is slow) and with a.
    `agility` is the part of that which the light makes use of, see `learned_agility`.
    """
    keep = math.exp(-dt / MANOEUVRE)
    density = 2.0 * agility * manoeuvre(state[2], state[3], state[4], state[5]) / MANOEUVRE
    half = 0.5 * dt * dt
    for i in range(2):
        state[i] += dt * state[2 + i] + half * state[4 + i]
        state[2 + i] += dt * state[4 + i]
        state[4 + i] *= keep
    for j in range(STATE):  # rows, then columns
        for i in range(2):
            work[i, j] = covariance[i, j] + dt * covariance[2 + i, j] + half * covariance[4 + i, j]
            work[2 + i, j] = covariance[2 + i, j] + dt * covariance[4 + i, j]
            work[4 + i, j] = keep * covariance[4 + i, j]
    for i in range(STATE):
        for j in range(2):
            covariance[i, j] = work[i, j] + dt * work[i, 2 + j] + half * work[i, 4 + j]
            covariance[i, 2 + j] = work[i, 2 + j] + dt * work[i, 4 + j]
            covariance[i, 4 + j] = keep * work[i, 4 + j]
    d2, d3 = dt * dt, dt * dt * dt
    for i in range(2):
        covariance[i, i] += density * d2 * d3 / 20.0
        covariance[2 + i, 2 + i] += density * d3 / 3.0
        covariance[4 + i, 4 + i] += density * dt
        covariance[i, 2 + i] += density * d2 * d2 / 8.0
        covariance[i, 4 + i] += density * d3 / 6.0
        covariance[2 + i, 4 + i] += density * d2 / 2.0
        covariance[2 + i, i] = covariance[i, 2 + i]
        covariance[4 + i, i] = covariance[i, 4 + i]
        covariance[4 + i, 2 + i] = covariance[2 + i, 4 + i]


@kernel
def learned_agility(agility: float, distance: float, predicted: float) -> float:
    """
    Return the agility after an innovation.

    Parameters
    ----------
    agility : float
        The part of the variance of its manoeuvres that a light made use of up to now.
    distance : float
        d^T S^-1 d of the innovation: 2 in the mean where S is true (Mehra, Approaches to adaptive
        filtering, IEEE Trans. AC 17 (1972)).
    predicted : float
        Part of S that is of the prediction, not of the noise of the point: what it tells of it.

    """
    surprise = min(0.5 * distance, MOST_SURPRISE) - 1.0
    return min(max(agility * math.exp(LEARNED * predicted * surprise), CALMEST), 1.0)


@kernel
def project(
    state: Array, covariance: Array, tau: float
) -> tuple[float, float, float, float, float]:
    """Return place and its variances xx, xy, yy at the time tau from the state's."""
    half = 0.5 * tau * tau
    x = state[0] + tau * state[2] + half * state[4]
    y = state[1] + tau * state[3] + half * state[5]
    xx, xy, yy = 0.0, 0.0, 0.0
    for p in range(3):
        hp = 1.0 if p == 0 else (tau if p == 1 else half)
        for q in range(3):
            h = hp * (1.0 if q == 0 else (tau if q == 1 else half))
            xx += h * covariance[2 * p, 2 * q]
            xy += h * covariance[2 * p, 2 * q + 1]
            yy += h * covariance[2 * p + 1, 2 * q + 1]
    return x, y, xx, xy, yy


@kernel
def mahalanobis(dx: float, dy: float, xx: float, xy: float, yy: float) -> tuple[float, float]:
    """Return the Mahalanobis distance squared, and the determinant."""
    determinant = max(xx * yy - xy * xy, 1e-12)
    return (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / determinant, determinant


@kernel
def correct(
    state: Array, covariance: Array, tau: float, dx: float, dy: float, sxx: float, sxy: float,
    syy: float, work: Array,
) -> None:
    """
    Take the place that was seen at tau: the innovation and its covariance are given.

    K = P H^T S^-1, x += K d, P -= K S K^T.
    """
    half = 0.5 * tau * tau
    determinant = sxx * syy - sxy * sxy
    ixx, ixy, iyy = syy / determinant, -sxy / determinant, sxx / determinant
    for i in range(STATE):
        gx = covariance[i, 0] + tau * covariance[i, 2] + half * covariance[i, 4]
        gy = covariance[i, 1] + tau * covariance[i, 3] + half * covariance[i, 5]
        work[0, i], work[1, i] = gx, gy
        work[2, i], work[3, i] = gx * ixx + gy * ixy, gx * ixy + gy * iyy
    for i in range(STATE):
        state[i] += work[2, i] * dx + work[3, i] * dy
        for j in range(STATE):
            covariance[i, j] -= work[2, i] * work[0, j] + work[3, i] * work[1, j]


@kernel
def begin(
    state: Array, covariance: Array, x: float, y: float, xx: float, xy: float, yy: float,
    speed: float,
) -> None:
    """Begin with a place and a speed that it may have along each axis."""
    state[:] = 0.0
    state[0], state[1] = x, y
    covariance[:] = 0.0
    covariance[0, 0], covariance[0, 1], covariance[1, 0], covariance[1, 1] = xx, xy, xy, yy
    acceleration = manoeuvre(speed, 0.0, 0.0, 0.0)
    for i in range(2):
        covariance[2 + i, 2 + i] = speed * speed
        covariance[4 + i, 4 + i] = acceleration
