"""Whether a gyro says what the picture does, from the bearings and samples of the last seconds."""

from __future__ import annotations

from collections import defaultdict, deque

from blob_tracker.tracking.direction import placed
from blob_tracker.tracking.errors import TrackingError
from blob_tracker.tracking.gyro_fit import Fit, fit_gyro, GyroFault, Moves, moves_of
from blob_tracker.tracking.measurement import measured
from blob_tracker.tracking.pan_tilt import PanTilt
from blob_tracker.types import Bearing
import numpy as np
from numpy.typing import ArrayLike, NDArray

KEPT_S = 10.0  # some swings of a boat
SHORTEST_S, LONGEST_S = 0.08, 0.5  # of an interval between two bearings: a turn is small in it
DENSEST_S = 0.004  # between two samples that are kept: nothing that the picture shows is faster


class GyroWatch:
    """
    Compare a gyro with the bearings of lights, which move with the base as it turns.

    Attributes
    ----------
    fault : GyroFault or None
        What is wrong with it, by the last time that the turning was enough to tell.

    Examples
    --------
    A gyro whose rates have the wrong sign, in a vehicle of the virtual lab that looks at a still
    light straight ahead:

    >>> import numpy as np
    >>> from blob_tracker.simulation.platform_motion import MOTIONS
    >>> ride, watch = MOTIONS['rover'].ride(9.0, seed=1), GyroWatch()
    >>> times = np.arange(0.0, 8.0, 0.01)
    >>> for time, rate in zip(times, ride.rates(times)):
    ...     watch.push(round(1e9 * time), -rate)
    >>> for time, (x, y, z) in zip(times[::4], ride.rotations(times[::4])[:, 2]):
    ...     azimuth, elevation = 1e3 * np.arctan2(x, z), 1e3 * np.arctan2(-y, np.hypot(x, z))
    ...     watch.saw('', Bearing(azimuth, elevation, 1e-4 * np.eye(2), round(1e9 * time)), None)
    >>> watch.judge().fault.words
    'its rates have the wrong sign'

    """

    def __init__(self) -> None:
        self.fault: GyroFault | None = None
        self._samples: deque[tuple[float, NDArray[np.float64]]] = deque()
        self._seen: defaultdict[str, deque[tuple[float, NDArray[np.float64]]]] = defaultdict(deque)

    def reset(self) -> None:
        """Forget what came; what was found stays."""
        self._samples.clear()
        self._seen.clear()

    def push(self, stamp_ns: int, rate: ArrayLike) -> None:
        """Take a sample of the gyro, rad/s in the base's axes, by its stamp, ns."""
        _keep(self._samples, stamp_ns, rate, DENSEST_S)

    def saw(self, light: str, bearing: Bearing, pan_tilt: PanTilt | None) -> None:
        """Take a bearing of a light; one that has no direction in the base is left out."""
        try:
            azimuth, elevation, _, _, _, camera = measured(bearing, pan_tilt)
        except TrackingError:  # whoever tracks it says so
            return
        direction = placed(azimuth, elevation, camera)[:, 2]
        _keep(self._seen[light], bearing.stamp_ns, direction, 0.0)

    def judge(self) -> Fit:
        """Compare what has come."""
        fit = Fit(False, None)
        parts = [
            moves_of(*_arrays(seen), SHORTEST_S, LONGEST_S)
            for seen in self._seen.values() if len(seen) > 1
        ]
        if parts and len(self._samples) > 1:
            moves = Moves(*(np.concatenate(each) for each in zip(*parts)))
            fit = fit_gyro(moves, *_arrays(self._samples))
        if fit.told:
            self.fault = fit.fault
        return fit


def _keep(
    kept: deque[tuple[float, NDArray[np.float64]]], stamp_ns: int, value: ArrayLike, apart: float
) -> None:
    """Keep a value in the order of time; one that is late, or too close, is not needed."""
    time = 1e-9 * stamp_ns
    if kept and time <= kept[-1][0] + apart:
        return
    kept.append((time, np.asarray(value, dtype=float)))
    while kept[0][0] < time - KEPT_S:
        kept.popleft()


def _arrays(
    kept: deque[tuple[float, NDArray[np.float64]]]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return times, (n,), and values, (n, 3)."""
    times, values = zip(*kept)
    return np.array(times), np.array(values)
