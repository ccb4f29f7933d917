"""The pose, and the twist, of maximum likelihood for bearings of known lights."""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel
import numpy as np

STEPS = 100
CONVERGED = 1e-4  # squared step over its covariance: the next one is less by far
MOST_DAMPING = 1e8
# Chi-square of a bearing, and the share of it that a step gains: no pose lies that way.
HOPELESS, GAIN = 100.0, 1e-3


@kernel
def fit(
    places: Array, variances: Array, rays: Array, bases: Array, noise: Array, apart: Array,
    used: Array, rates: Array, expected: Array, rotation: Array, position: Array, twist: Array,
    information: Array, chi2: Array,
) -> float:
    """
    Take a pose to the greatest likelihood of bearings, in place (Levenberg and Marquardt).

    A light at X of the body, seen an interval dt off the pose's instant, is in the direction of

        p = exp([w dt]x) R X + t + v dt

    and the residual is the way on the sphere from p to the measured ray, in the tangent plane of
    that ray,

        r = theta / sin(theta) B^T p / |p|,    cos(theta) = ray . p / |p|

    with the basis B along azimuth and elevation. Its covariance is that of the bearing and of the
    light's place, S = C + sigma^2 / |p|^2 I. Minimised is sum r^T S^-1 r, and, where there is more
    than one instant, the squared twist less its mean over its variances.

    Parameters
    ----------
    places, variances : (k, 3), (k,) arrays
        Of the light of each bearing: place in the body's frame, m, and variance along an axis,
        m^2.
    rays, bases, noise : (k, 3), (k, 3, 2), (k, 2, 2) arrays
        Measured unit vector, basis of its tangent plane, and covariance in it, rad^2.
    apart : (k,) array
        Stamp less that of the pose, s.
    used : (k,) array
        1 of bearings that count, 0 of others.
    rates : (2,) array
        Standard deviations of velocity, m/s, and angular rate, rad/s; zero where all bearings are
        of one instant: there is no twist then.
    expected : (6,) array
        Their means.
    rotation, position, twist : (3, 3), (3,), (6,) arrays
        Start; hold the fit afterwards. Body's frame to optical frame; m; v, m/s, and w, rad/s.
    information : (12, 12) array
        Is filled with the Fisher information of position, turn (about the optical axes), v, w.
    chi2 : (k,) array
        Is filled with the squared residual of each bearing over S, of those not used, too.

    Returns
    -------
    float
        What was minimised.

    """
    size = 12 if rates[0] > 0.0 else 6
    gradient = np.empty(12)
    trial = np.empty((12, 12))
    spare = np.empty(len(chi2))
    new_rotation, new_position, new_twist = np.empty((3, 3)), np.empty(3), np.empty(6)
    cost = linearise(
        places, variances, rays, bases, noise, apart, used, rates, expected, rotation, position,
        twist, information, gradient, chi2,
    )
    damping = 1e-4
    for _ in range(STEPS):
        system, step = information.copy(), gradient.copy()
        for i in range(size):
            system[i, i] *= 1.0 + damping
        solve(system, step, size)
        move(rotation, position, twist, step, size, new_rotation, new_position, new_twist)
        pull = np.empty(12)
        new_cost = linearise(
            places, variances, rays, bases, noise, apart, used, rates, expected,
            new_rotation, new_position, new_twist, trial, pull, spare,
        )
        square = 0.0
        for i in range(size):
            for j in range(size):
                square += step[i] * information[i, j] * step[j]
        if new_cost <= cost + 1e-12:
            rotation[:], position[:], twist[:] = new_rotation, new_position, new_twist
            information[:], gradient[:], chi2[:] = trial, pull, spare
            gained, cost = cost - new_cost, new_cost
            damping *= 0.1
            hopeless = cost > HOPELESS * len(chi2) and gained < GAIN * cost
            if hopeless or (square < CONVERGED and damping < 1.0):
                break
        else:
            damping *= 10.0
            if damping > MOST_DAMPING:
                break
    return cost


@kernel
def linearise(
    places: Array, variances: Array, rays: Array, bases: Array, noise: Array, apart: Array,
    used: Array, rates: Array, expected: Array, rotation: Array, position: Array, twist: Array,
    information: Array, gradient: Array, chi2: Array,
) -> float:
    """Return what `fit` minimises; fill information, gradient (downhill) and chi2 at a pose."""
    size = 12 if rates[0] > 0.0 else 6
    information[:] = 0.0
    gradient[:] = 0.0
    cost = 0.0
    jacobian = np.zeros((2, 12))
    arm, point, turned = np.empty(3), np.empty(3), np.empty(3)
    residual, turn = np.empty(2), np.empty((3, 3))
    for k in range(len(rays)):
        distance, scale = _seen(
            places, rays, bases, apart, rotation, position, twist, k, turn, arm, point, residual)
        for a in range(2):
            x, y, z = bases[k, 0, a], bases[k, 1, a], bases[k, 2, a]
            beside = residual[a] / scale
            x = scale * (x - beside * point[0] / distance) / distance
            y = scale * (y - beside * point[1] / distance) / distance
            z = scale * (z - beside * point[2] / distance) / distance
            jacobian[a, 0], jacobian[a, 1], jacobian[a, 2] = x, y, z
            turned[0] = arm[1] * z - arm[2] * y
            turned[1] = arm[2] * x - arm[0] * z
            turned[2] = arm[0] * y - arm[1] * x
            for i in range(3):  # the pose is turned before the body has turned on
                jacobian[a, 3 + i] = (
                    turn[0, i] * turned[0] + turn[1, i] * turned[1] + turn[2, i] * turned[2]
                )
            if size == 6:
                continue
            for i in range(3):
                jacobian[a, 6 + i] = apart[k] * jacobian[a, i]
                # Half of the way that it turns on, to first order.
                one, two = (i + 1) % 3, (i + 2) % 3
                jacobian[a, 9 + i] = apart[k] * (turned[i] - 0.5 * apart[k] * (
                    twist[3 + one] * turned[two] - twist[3 + two] * turned[one]
                ))
        weight_x, weight_y, weight_xy = _weights(noise, variances, k, distance)
        chi2[k] = (
            weight_x * residual[0]**2 + 2.0 * weight_xy * residual[0] * residual[1]
            + weight_y * residual[1]**2
        )
        if used[k] == 0.0:
            continue
        cost += chi2[k]
        for i in range(size):
            first = weight_x * jacobian[0, i] + weight_xy * jacobian[1, i]
            second = weight_xy * jacobian[0, i] + weight_y * jacobian[1, i]
            gradient[i] -= first * residual[0] + second * residual[1]
            for j in range(i + 1):
                information[i, j] += first * jacobian[0, j] + second * jacobian[1, j]
    for i in range(size):
        for j in range(i):
            information[j, i] = information[i, j]
    for i in range(6, size):
        weight = 1.0 / rates[(i - 6) // 3]**2
        information[i, i] += weight
        gradient[i] -= weight * (twist[i - 6] - expected[i - 6])
        cost += weight * (twist[i - 6] - expected[i - 6])**2
    return cost


@kernel
def score(
    places: Array, variances: Array, rays: Array, bases: Array, noise: Array, apart: Array,
    rotation: Array, position: Array, twist: Array, most_chi2: float,
) -> float:
    """Return the sum of min(chi2, most_chi2) over the bearings, at a pose."""
    arm, point = np.empty(3), np.empty(3)
    residual, turn = np.empty(2), np.empty((3, 3))
    total = 0.0
    for k in range(len(rays)):
        distance, _ = _seen(
            places, rays, bases, apart, rotation, position, twist, k, turn, arm, point, residual)
        weight_x, weight_y, weight_xy = _weights(noise, variances, k, distance)
        total += min(
            weight_x * residual[0]**2 + 2.0 * weight_xy * residual[0] * residual[1]
            + weight_y * residual[1]**2, most_chi2,
        )
    return total


@kernel
def _seen(
    places: Array, rays: Array, bases: Array, apart: Array, rotation: Array, position: Array,
    twist: Array, k: int, turn: Array, arm: Array, point: Array, residual: Array,
) -> tuple[float, float]:
    """
    Fill in where a light is and what it is off its ray; return its distance and the arc's length.

    `turn` is filled with how the body has turned on, `arm` and `point` with the light's place from
    the body's origin and from the camera, m; the arc is over its sine.
    """
    turn_by(twist[3] * apart[k], twist[4] * apart[k], twist[5] * apart[k], turn)
    for i in range(3):
        point[i] = 0.0
        for j in range(3):
            point[i] += rotation[i, j] * places[k, j]
    for i in range(3):
        arm[i] = turn[i, 0] * point[0] + turn[i, 1] * point[1] + turn[i, 2] * point[2]
    for i in range(3):
        point[i] = arm[i] + position[i] + twist[i] * apart[k]
    distance = np.sqrt(point[0]**2 + point[1]**2 + point[2]**2) + 1e-300
    along = (rays[k, 0] * point[0] + rays[k, 1] * point[1] + rays[k, 2] * point[2]) / distance
    for a in range(2):
        residual[a] = (
            bases[k, 0, a] * point[0] + bases[k, 1, a] * point[1] + bases[k, 2, a] * point[2]
        ) / distance
    sine = np.sqrt(residual[0]**2 + residual[1]**2)
    scale = np.arctan2(sine, along) / sine if sine > 1e-9 else 1.0
    residual[0] *= scale
    residual[1] *= scale
    return distance, scale


@kernel
def _weights(
    noise: Array, variances: Array, k: int, distance: float
) -> tuple[float, float, float]:
    """Return the inverse of a bearing's covariance, with that of the light's place: xx, yy, xy."""
    extra = variances[k] / distance**2
    xx, yy, xy = noise[k, 0, 0] + extra, noise[k, 1, 1] + extra, noise[k, 0, 1]
    determinant = xx * yy - xy**2
    return yy / determinant, xx / determinant, -xy / determinant


@kernel
def move(
    rotation: Array, position: Array, twist: Array, step: Array, size: int,
    new_rotation: Array, new_position: Array, new_twist: Array,
) -> None:
    """Fill in the pose and twist a step further; the turn is about the optical axes."""
    turn = np.empty((3, 3))
    turn_by(step[3], step[4], step[5], turn)
    for i in range(3):
        new_position[i] = position[i] + step[i]
        for j in range(3):
            new_rotation[i, j] = (
                turn[i, 0] * rotation[0, j] + turn[i, 1] * rotation[1, j]
                + turn[i, 2] * rotation[2, j]
            )
    for i in range(6):
        new_twist[i] = twist[i]
        if size == 12:
            new_twist[i] += step[6 + i]


@kernel
def turn_by(x: float, y: float, z: float, turn: Array) -> None:
    """Fill in the turn by a rotation vector (Rodrigues)."""
    angle2 = x * x + y * y + z * z
    for i in range(3):
        for j in range(3):
            turn[i, j] = 1.0 if i == j else 0.0
    if angle2 < 1e-30:
        return
    angle = np.sqrt(angle2)
    first, second = np.sin(angle) / angle, (1.0 - np.cos(angle)) / angle2
    turn[0, 0] -= second * (y * y + z * z)
    turn[1, 1] -= second * (x * x + z * z)
    turn[2, 2] -= second * (x * x + y * y)
    turn[0, 1] += second * x * y - first * z
    turn[1, 0] += second * x * y + first * z
    turn[0, 2] += second * x * z + first * y
    turn[2, 0] += second * x * z - first * y
    turn[1, 2] += second * y * z - first * x
    turn[2, 1] += second * y * z + first * x


@kernel
def solve(system: Array, right: Array, size: int) -> None:
    """Solve a positive definite system in place (Cholesky)."""
    for i in range(size):
        for j in range(i + 1):
            value = system[i, j]
            for k in range(j):
                value -= system[i, k] * system[j, k]
            if i == j:
                system[i, i] = np.sqrt(max(value, 1e-300))
            else:
                system[i, j] = value / system[j, j]
    for i in range(size):
        for k in range(i):
            right[i] -= system[i, k] * right[k]
        right[i] /= system[i, i]
    for i in range(size - 1, -1, -1):
        for k in range(i + 1, size):
            right[i] -= system[k, i] * right[k]
        right[i] /= system[i, i]
