"""The process noise that recorded bearings speak for."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, inf, log, pi

from blob_tracker.tracking.errors import TrackingError
from blob_tracker.tracking.models import MODELS
from blob_tracker.tracking.pan_tilt_angles import PanTiltAngles
from blob_tracker.tracking.platform_rates import PlatformRates
from blob_tracker.tracking.tracker import Tracker
from blob_tracker.types import Bearing

# mrad/s^2 or mrad/s^3: from a light on a wall, to a turn of a second's length that is there within
# a thousandth of it.
LEAST, MOST = 1e-2, 1e6
SETTLING = 3  # innovations at the start of a track, which tell of the prior
FEWEST = 50  # innovations: the deviation of what is found is 10 % then
# Where a track ended by its deviation, a great noise would leave few innovations to explain.
ANY_SIGMA_MRAD = 1e12
FOUND = 0.01  # of the value, to which it is searched for


def log_likelihood(
    bearings: Sequence[Bearing],
    model: str,
    value: float,
    *,
    platform: PlatformRates | None = None,
    pan_tilt: PanTiltAngles | None = None,
    coast: float = 0.5,
) -> tuple[float, int]:
    """
    Return how well a process noise explains bearings.

    The innovations v of the right filter are independent, with the covariance S that it states:

        log L = -1/2 sum(v^T S^-1 v + log det(2 pi S))

    (Schweppe, Evaluation of Likelihood Functions for Gaussian Signals, IEEE Trans. Inf. Theory
    11, 1965.)

    Parameters
    ----------
    bearings : sequence of Bearing
        Of one light, without any other; in any order within a second.
    model : str
        A key of MODELS.
    value : float
        Its process noise, mrad/s^2 or mrad/s^3; that of the target alone where there is a
        `platform`.
    platform, pan_tilt : optional
        As the `Tracker` takes them, with a memory that holds the whole recording.
    coast : float
        Longest gap that is filtered over, s.

    Returns
    -------
    float, int
        log L, and the number of innovations in it.

    Examples
    --------
    Bearings of a still light: that it is still is likelier than that it is wild:

    >>> import numpy as np
    >>> random = np.random.default_rng(1)
    >>> bearings = [
    ...     Bearing(*random.normal(0.0, 0.1, 2), 0.01 * np.eye(2), 33_333_333 * index)
    ...     for index in range(100)
    ... ]
    >>> still, count = log_likelihood(bearings, 'constant_velocity', 1.0)
    >>> wild, _ = log_likelihood(bearings, 'constant_velocity', 1000.0)
    >>> still > wild, count
    (True, 96)

    """
    noise = MODELS[model].noise
    tracker = Tracker(
        model, **{noise: value, f'stabilised_{noise}': value}, gate_sigma=inf, coast=coast,
        max_sigma=ANY_SIGMA_MRAD, platform=platform, pan_tilt=pan_tilt,
    )
    total, count, age = 0.0, 0, 0
    for bearing in sorted(bearings, key=lambda each: each.stamp_ns):
        tracker.update(bearing)
        innovation = tracker.innovation
        age = 0 if innovation is None else age + 1
        if innovation is not None and age > SETTLING:
            total -= 0.5 * (innovation.squared + innovation.log_determinant) + log(2.0 * pi)
            count += 1
    return total, count


def process_noise(
    bearings: Sequence[Bearing],
    model: str,
    *,
    platform: PlatformRates | None = None,
    pan_tilt: PanTiltAngles | None = None,
    coast: float = 0.5,
) -> float:
    """
    Return the process noise that makes recorded bearings most likely.

    Parameters
    ----------
    bearings, model, platform, pan_tilt, coast
        As of `log_likelihood`.

    Returns
    -------
    float
        mrad/s^2 for `constant_velocity`, mrad/s^3 for `constant_acceleration`: the `Tracker`'s
        parameter of that model, or the `stabilised_` one where there is a `platform`.

    Raises
    ------
    TrackingError
        If a bearing is none that can be, or they are too few.

    Examples
    --------
    A light whose rate changes by 40 mrad/s in a second, standard deviation:

    >>> import numpy as np
    >>> random = np.random.default_rng(1)
    >>> rates = np.cumsum(random.normal(0.0, 40.0 / 30.0**0.5, (600, 2)), axis=0)  # mrad/s
    >>> angles = np.cumsum(rates / 30.0, axis=0) + random.normal(0.0, 0.1, (600, 2))
    >>> bearings = [
    ...     Bearing(*angle, 0.01 * np.eye(2), 33_333_333 * index)
    ...     for index, angle in enumerate(angles)
    ... ]
    >>> round(process_noise(bearings, 'constant_velocity'), -1)  # mrad/s^2
    40.0

    """
    import scipy  # no part of a start

    def loss(exponent: float) -> float:
        return -log_likelihood(
            bearings, model, exp(exponent), platform=platform, pan_tilt=pan_tilt, coast=coast
        )[0]

    _, count = log_likelihood(
        bearings, model, 1.0, platform=platform, pan_tilt=pan_tilt, coast=coast
    )
    if count < FEWEST:
        raise TrackingError(
            f'{count} bearings follow others closely enough; {FEWEST} at least determine the '
            'process noise'
        )
    found = scipy.optimize.minimize_scalar(
        loss, bounds=(log(LEAST), log(MOST)), method='bounded', options={'xatol': FOUND}
    )
    return exp(float(found.x))
