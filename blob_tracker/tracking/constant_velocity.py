"""Nearly constant velocity: white noise is the acceleration."""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel


@kernel
def constant_velocity(dt: float, density: float, transition: Array, noise: Array) -> None:
    """
    Fill the transition and the process noise of a step, exact for any length.

    For each axis, with the spectral density q of the acceleration,

        F = [1 dt; 0 1],  Q = q [dt^3/3 dt^2/2; dt^2/2 dt]

    (Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation, eq.
    6.2.2-12).

    Parameters
    ----------
    dt : float
        s.
    density : float
        q, mrad^2/s^3.
    transition, noise : (4, 4) arrays
        F and Q, to be filled; order of the state: both angles, both rates.

    """
    transition[:] = 0.0
    noise[:] = 0.0
    for axis in range(2):
        rate = 2 + axis
        transition[axis, axis] = transition[rate, rate] = 1.0
        transition[axis, rate] = dt
        noise[axis, axis] = density * dt**3 / 3.0
        noise[axis, rate] = noise[rate, axis] = density * dt**2 / 2.0
        noise[rate, rate] = density * dt
