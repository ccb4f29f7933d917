"""How one frame lies in another."""

from __future__ import annotations

from math import atan2, isfinite, sin, sqrt
from typing import NamedTuple

from blob_tracker.transforms.errors import TransformError
import numpy as np
from numpy.typing import NDArray

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

UNIT = 1e-3  # that the length of a quaternion may be off 1: more is no rounding
# rad between two quaternions, below which the line between them is the arc to double precision.
STRAIGHT = 1e-8


class Transform(NamedTuple):
    """
    How a frame lies in its parent: a point p of it is at R p + translation there.

    Parameters
    ----------
    translation : tuple of float
        x, y, z, m.
    rotation : tuple of float
        x, y, z, w of the unit quaternion of R.

    """

    translation: Vector = (0.0, 0.0, 0.0)
    rotation: Quaternion = (0.0, 0.0, 0.0, 1.0)

    @property
    def matrix(self) -> NDArray[np.float64]:
        """Return R, (3, 3): takes components in the frame to those in its parent."""
        x, y, z, w = self.rotation
        return np.array([
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ])


def checked(transform: Transform) -> Transform:
    """
    Return a transform with a quaternion whose length is 1 to rounding.

    Raises
    ------
    TransformError
        If a number is not finite, or the quaternion is no turn.

    """
    numbers = *transform.translation, *transform.rotation
    if not all(map(isfinite, numbers)):
        raise TransformError(f'its numbers are {_listed(numbers)}; all must be finite')
    x, y, z, w = transform.rotation
    length = sqrt(x * x + y * y + z * z + w * w)
    if not abs(length - 1.0) <= UNIT:
        raise TransformError(
            f'its quaternion {_listed(transform.rotation)} has the length {length:g}; it must '
            'have the length 1'
        )
    return Transform(transform.translation, (x / length, y / length, z / length, w / length))


def product(outer: Transform, inner: Transform) -> Transform:
    """Return how a frame lies in another, of how it lies in a third and that in the other."""
    px, py, pz = _turned(outer.rotation, inner.translation)
    ox, oy, oz = outer.translation
    ax, ay, az, aw = outer.rotation
    bx, by, bz, bw = inner.rotation
    return Transform(
        (ox + px, oy + py, oz + pz),
        (
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ),
    )


def inverse(transform: Transform) -> Transform:
    """Return how the parent lies in the frame."""
    x, y, z, w = transform.rotation
    back = -x, -y, -z, w
    px, py, pz = _turned(back, transform.translation)
    return Transform((-px, -py, -pz), back)


def interpolated(before: Transform, after: Transform, part: float) -> Transform:
    """
    Return the transform when a part, 0 to 1, of the time between two has passed.

    The translation is on the line, the rotation on the shorter great circle (slerp; K. Shoemake,
    Animating Rotation with Quaternion Curves, SIGGRAPH 1985), as tf2 has it.
    """
    rest = 1.0 - part
    ax, ay, az, aw = before.rotation
    bx, by, bz, bw = after.rotation
    if ax * bx + ay * by + az * bz + aw * bw < 0.0:  # the same turn, the short way round
        bx, by, bz, bw = -bx, -by, -bz, -bw
    apart = sqrt((ax - bx) ** 2 + (ay - by) ** 2 + (az - bz) ** 2 + (aw - bw) ** 2)
    across = sqrt((ax + bx) ** 2 + (ay + by) ** 2 + (az + bz) ** 2 + (aw + bw) ** 2)
    angle = 2.0 * atan2(apart, across)
    one, other = rest, part
    if angle > STRAIGHT:
        one, other = sin(rest * angle) / sin(angle), sin(part * angle) / sin(angle)
    x, y, z, w = (
        one * ax + other * bx, one * ay + other * by, one * az + other * bz, one * aw + other * bw
    )
    length = sqrt(x * x + y * y + z * z + w * w)
    px, py, pz = before.translation
    qx, qy, qz = after.translation
    return Transform(
        (rest * px + part * qx, rest * py + part * qy, rest * pz + part * qz),
        (x / length, y / length, z / length, w / length),
    )


def _turned(turn: Quaternion, vector: Vector) -> Vector:
    """Return R v = v + 2 w (u x v) + 2 u x (u x v), of the quaternion (u, w)."""
    x, y, z, w = turn
    px, py, pz = vector
    cx, cy, cz = 2.0 * (y * pz - z * py), 2.0 * (z * px - x * pz), 2.0 * (x * py - y * px)
    return (
        px + w * cx + y * cz - z * cy, py + w * cy + z * cx - x * cz, pz + w * cz + x * cy - y * cx
    )


def _listed(numbers: tuple[float, ...]) -> str:
    return f'({", ".join(f"{each:g}" for each in numbers)})'
