"""The motion models by name."""

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
from blob_tracker.tracking.constant_acceleration import constant_acceleration
from blob_tracker.tracking.constant_velocity import constant_velocity


class Model(NamedTuple):
    """
    A motion model.

    Parameters
    ----------
    size : int
        Numbers in the state: two angles and their derivatives.
    noise : str
        The `Tracker`'s parameter that is its process noise.

    """

    size: int
    noise: str


# The value of the parameter `model`.
MODELS = {
    'constant_velocity': Model(4, 'acceleration'),
    'constant_acceleration': Model(6, 'jerk'),
}


@kernel
def fill_step(dt: float, density: float, transition: Array, noise: Array) -> None:
    """Fill transition and process noise of the model whose state is of this size."""
    if transition.shape[0] == 4:
        constant_velocity(dt, density, transition, noise)
    else:
        constant_acceleration(dt, density, transition, noise)
