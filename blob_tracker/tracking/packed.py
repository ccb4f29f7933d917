"""
The filter's steps on a state that is one array: what is called from outside of the kernels.

Between Python and a kernel each array costs a fifth of a microsecond, each tuple of arrays more
than one: as much as the arithmetic. So a state goes as one array, and all else as plain numbers.
"""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel
from blob_tracker.tracking import direction, kalman
from blob_tracker.tracking.direction import State
from blob_tracker.tracking.kalman import Measurement, Step
import numpy as np

AXES = 9  # numbers of the axes; the motion and the covariance follow


@kernel
def unpacked(held: Array) -> State:
    """Return the state in an array: views, for n of 4 and 6 of (27,) and (49,)."""
    size = 4 if held.size == AXES + 2 + 16 else 6
    motion = AXES + size - 2
    return State(
        held[:AXES].reshape(3, 3), held[AXES:motion], held[motion:].reshape(size, size)
    )


@kernel
def packed(state: State) -> Array:
    """Return a state as one array."""
    size = state.covariance.shape[0]
    motion = AXES + size - 2
    held = np.empty(motion + size * size)
    held[:AXES] = state.axes.reshape(AXES)
    held[AXES:motion] = state.motion
    held[motion:] = state.covariance.reshape(size * size)
    return held


@kernel
def initiated(
    azimuth: float, elevation: float, rr: float, ru: float, uu: float, camera: Array,
    rate: float, acceleration: float, size: int,
) -> Array:
    """Return what `kalman.initiated` does."""
    measurement = Measurement(azimuth, elevation, rr, ru, uu, camera)
    return packed(kalman.initiated(measurement, rate, acceleration, size))


@kernel
def predicted(
    held: Array, seconds: float, density: float, turn: Array, variance: float
) -> Array:
    """Return what `kalman.predicted` does."""
    return packed(kalman.predicted(unpacked(held), Step(seconds, density, turn, variance)))


@kernel
def updated(
    held: Array, gate_squared: float,
    seconds: float, density: float, turn: Array, variance: float,
    azimuth: float, elevation: float, rr: float, ru: float, uu: float, camera: Array,
) -> tuple[bool, Array, float, float, float, float]:
    """Return what `kalman.updated` does of the state that is `predicted`, and its deviation."""
    before = kalman.predicted(unpacked(held), Step(seconds, density, turn, variance))
    measurement = Measurement(azimuth, elevation, rr, ru, uu, camera)
    passed, state, innovation = kalman.updated(before, measurement, gate_squared)
    return (
        passed, packed(state), innovation.first, innovation.second, innovation.log_determinant,
        kalman.largest_deviation(before),
    )


@kernel
def with_rates(held: Array, rotation: Array, sign: float, acceleration: float) -> Array:
    """Return what `direction.with_rates` does."""
    return packed(direction.with_rates(unpacked(held), rotation, sign, acceleration))


@kernel
def with_motion_forgotten(held: Array, rate: float, acceleration: float) -> Array:
    """Return what `kalman.with_motion_forgotten` does."""
    return packed(kalman.with_motion_forgotten(unpacked(held), rate, acceleration))


@kernel
def as_angles(held: Array, frame: Array) -> tuple[Array, Array]:
    """Return what `direction.as_angles` does."""
    return direction.as_angles(unpacked(held), frame)


@kernel
def largest_deviation(held: Array) -> float:
    """Return what `kalman.largest_deviation` does."""
    return kalman.largest_deviation(unpacked(held))
