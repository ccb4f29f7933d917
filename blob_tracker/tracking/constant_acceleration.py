"""Nearly constant acceleration: white noise is the jerk."""

from __future__ import annotations

from blob_tracker.kernel import Array, kernel


@kernel
def constant_acceleration(dt: float, density: float, transition: Array, noise: Array) -> None:
    """
    Fill the transition and the process noise of a step, exact for any length.

    For each axis, with the spectral density q of the jerk,

        F = [1 dt dt^2/2; 0 1 dt; 0 0 1]
        Q = q [dt^5/20 dt^4/8 dt^3/6; dt^4/8 dt^3/3 dt^2/2; dt^3/6 dt^2/2 dt]

    (Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation, eq.
    6.2.3-9).

    Parameters
    ----------
    dt : float
        s.
    density : float
        q, mrad^2/s^5.
    transition, noise : (6, 6) arrays
        F and Q, to be filled; order of the state: both angles, both rates, both accelerations.

    """
    transition[:] = 0.0
    noise[:] = 0.0
    for axis in range(2):
        rate, acceleration = 2 + axis, 4 + axis
        transition[axis, axis] = transition[rate, rate] = 1.0
        transition[acceleration, acceleration] = 1.0
        transition[axis, rate] = transition[rate, acceleration] = dt
        transition[axis, acceleration] = dt**2 / 2.0
        noise[axis, axis] = density * dt**5 / 20.0
        noise[axis, rate] = noise[rate, axis] = density * dt**4 / 8.0
        noise[axis, acceleration] = noise[acceleration, axis] = density * dt**3 / 6.0
        noise[rate, rate] = density * dt**3 / 3.0
        noise[rate, acceleration] = noise[acceleration, rate] = density * dt**2 / 2.0
        noise[acceleration, acceleration] = density * dt
