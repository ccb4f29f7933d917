"""Where a camera is and how it is turned."""

from __future__ import annotations

from dataclasses import dataclass, field
import math

from blob_tracker.kernel import Array
import numpy as np


@dataclass(frozen=True)
class CameraPose:
    """
    Where a camera is and how it is turned, in the frame of reference.

    Parameters
    ----------
    position : (3,) array
        Of its optical centre, m.
    rotation : (3, 3) array
        Takes components in the optical frame (x right, y down, z forward) to those in the
        reference.
    position_sigma : float
        Standard deviation of the position along each axis, m.
    rotation_sigma : float
        Standard deviation of the rotation about each axis, rad.

    Raises
    ------
    ValueError
        If one of them is invalid.

    Examples
    --------
    A camera 2 m up that looks along the reference's x axis, which is its own z axis:

    >>> rotation = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    >>> pose = CameraPose(np.array([0.0, 0.0, 2.0]), rotation, position_sigma=0.005)
    >>> (pose.position + pose.rotation @ [0.0, 0.0, 10.0]).tolist()  # m, 10 m before it
    [10.0, 0.0, 2.0]

    """

    position: Array
    rotation: Array = field(default_factory=lambda: np.eye(3))
    position_sigma: float = 0.0
    rotation_sigma: float = 0.0

    def __post_init__(self) -> None:
        if np.shape(self.position) != (3,) or not np.isfinite(self.position).all():
            raise ValueError(f'the position {self.position} must be 3 finite numbers')
        if np.shape(self.rotation) != (3, 3) or not (
            np.allclose(self.rotation @ self.rotation.T, np.eye(3), atol=1e-6)
            and np.linalg.det(self.rotation) > 0.0
        ):
            raise ValueError('the rotation must be a (3, 3) matrix that turns and does no more')
        for name in ('position_sigma', 'rotation_sigma'):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise ValueError(f'{name} is {getattr(self, name)}; it must be finite, 0 or more')
