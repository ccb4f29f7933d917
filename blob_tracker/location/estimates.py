"""What every location method returns for a stack of windows, and the ways in which it fails."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import NamedTuple

from blob_tracker.types import LocationError
import numpy as np
from numpy.typing import NDArray


class Failure(IntEnum):
    """Why a window has no location; 0 where it has one."""

    NONE = 0
    NOT_FINITE = 1
    SATURATED = 2
    FLAT = 3
    NO_SIGNAL = 4
    OUTSIDE = 5
    TOO_FEW_PIXELS = 6
    NOT_CONVERGED = 7
    TOO_NARROW = 8
    TOO_WIDE = 9
    CLIPPED = 10
    VAGUE = 11


REASONS = {
    Failure.NOT_FINITE: 'the window holds NaN, infinite or absurd (beyond 1e9 DN) pixels',
    Failure.SATURATED: 'every pixel of the window is saturated; lower the exposure',
    Failure.FLAT: 'the window is flat: all its pixels are equal',
    Failure.NO_SIGNAL: 'the window holds no light above its background',
    Failure.OUTSIDE: 'the estimate lies outside the window',
    Failure.TOO_FEW_PIXELS: 'too few pixels are left: the others are saturated or hold no light',
    Failure.NOT_CONVERGED: 'the fit did not settle: the window does not hold one blob',
    Failure.TOO_NARROW: 'the blob is a single pixel: a hot pixel, or a lens too sharp to place it',
    Failure.TOO_WIDE: 'the blob is wider than the window; enlarge the window',
    Failure.CLIPPED: 'the blob holds saturated pixels, which no look-up can leave out; lower the '
    'exposure or take maximum_likelihood',
    Failure.VAGUE: 'the pixels do not show where in the window the light is: it is too faint, or '
    'narrower than a pixel, or a cell of the colour mosaic',
}


@dataclass(frozen=True)
class Beside:
    """
    A second light that flashes with the target.

    Parameters
    ----------
    shift : (2,) array
        From the target to it, window px.
    excess : float
        By how much the target is brighter, in standard deviations of that.

    """

    shift: NDArray[np.float64]
    excess: float


NO_EVIDENCE: Mapping[str, float] = {}  # that the light is anything but one round pulse


class Estimate(NamedTuple):
    """
    One of `Estimates` that has a location, in Python's own numbers: arrays of one cost more time.

    Parameters
    ----------
    x, y, amplitude, background, sigma, snr, chi2 : float
        See `Estimates`.
    saturated : int
        Likewise.
    covariance : (2, 2) array
        Likewise.
    lopsided : (4,) sequence of float
        Likewise; empty if nobody looked.
    warning : str
        '' if there is none.
    evidence, beside, drawn, way
        As those of `Estimates`; empty, None, 0 and None if there is none.

    """

    x: float
    y: float
    amplitude: float
    background: float
    sigma: float
    snr: float
    chi2: float
    saturated: int
    covariance: NDArray[np.float64]
    lopsided: Sequence[float] = ()
    warning: str = ''
    evidence: Mapping[str, float] = NO_EVIDENCE
    beside: Beside | None = None
    drawn: float = 0.0
    way: NDArray[np.float64] | None = None


@dataclass
class Estimates:
    """
    Locations of N blobs in the coordinates of their windows (first pixel's centre at 0, 0).

    Parameters
    ----------
    x, y : (N,) array
        px.
    covariance : (N, 2, 2) array
        px^2, order x, y.
    amplitude, background, sigma, snr, chi2 : (N,) array
        As in `Location`: DN, DN, px, -, per degree of freedom.
    saturated : (N,) int array
        Count of clipped pixels.
    failure : (N,) uint8 array
        A `Failure` each; where it is not NONE the other values mean nothing.
    lopsided : (N, 4) array
        How far each pulse leans to one side: scores along x and y and their variances' inverse,
        see `suspicion.lopsidedness`. Empty where nobody looked.
    warnings : dict
        Of few windows, by their index: what the user should know and do.
    evidence : dict
        Likewise: log weights of the models that were heard, by their names, see `choose`.
    beside : dict
        Likewise: the second light, where there is one.
    drawn : dict
        Likewise: of a light whose rows are cut, by how much lower it is than it seems, window px.
    ways : dict
        Likewise: of a streak, from one end to the other, window px.
    other_models : dict
        Of the windows that another model than the method's own explains: its log-likelihood, of
        lit and unlit pixels together, and how many parameters it has. What `chi2` says is of
        both then.

    Examples
    --------
    A window in which there is nothing, and one with a light, as `locate_batch` tells of them:

    >>> from blob_tracker.location import locate_batch
    >>> from blob_tracker.types import SensorNoise
    >>> y, x = np.mgrid[:15, :15]
    >>> pulse = 150.0 * np.exp(-((x - 7.3) ** 2 + (y - 6.5) ** 2) / (2.0 * 2.0**2))
    >>> estimates = locate_batch(
    ...     np.stack([np.full((15, 15), 40.0), 40.0 + pulse]),
    ...     noise=SensorNoise(gain=40.0, read_noise=0.7),
    ... )
    >>> estimates.ok.tolist()
    [False, True]
    >>> estimates.first()
    Traceback (most recent call last):
        ...
    blob_tracker.types.LocationError: the window is flat: all its pixels are equal

    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    covariance: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    background: NDArray[np.float64]
    sigma: NDArray[np.float64]
    snr: NDArray[np.float64]
    chi2: NDArray[np.float64]
    saturated: NDArray[np.int64]
    failure: NDArray[np.uint8]
    lopsided: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 4)))
    warnings: dict[int, str] = field(default_factory=dict)
    evidence: dict[int, Mapping[str, float]] = field(default_factory=dict)
    beside: dict[int, Beside] = field(default_factory=dict)
    drawn: dict[int, float] = field(default_factory=dict)
    ways: dict[int, NDArray[np.float64]] = field(default_factory=dict)
    other_models: dict[int, tuple[float, int]] = field(default_factory=dict)

    @classmethod
    def from_table(
        cls,
        table: NDArray[np.float64],
        covariance: NDArray[np.float64],
        saturated: NDArray[np.int64],
        failure: NDArray[np.uint8],
        lopsided: NDArray[np.float64] | None = None,
    ) -> Estimates:
        """
        Return the estimates that a kernel has filled in.

        Parameters
        ----------
        table : (7, N) array
            Rows x, y, amplitude, background, sigma, SNR, chi2.
        covariance, saturated, failure, lopsided
            See the class.

        """
        x, y, amplitude, background, sigma, snr, chi2 = table
        return cls(
            x=x,
            y=y,
            covariance=covariance,
            amplitude=amplitude,
            background=background,
            sigma=sigma,
            snr=snr,
            chi2=chi2,
            saturated=saturated,
            failure=failure,
            lopsided=np.empty((0, 4)) if lopsided is None else lopsided,
        )

    def take(self, n: int, other: Estimates, k: int = 0) -> None:
        """Put the numbers of another's window k in the place of those of window n."""
        for name in (
            'x', 'y', 'covariance', 'amplitude', 'background', 'sigma', 'snr', 'chi2', 'failure',
        ):
            getattr(self, name)[n] = getattr(other, name)[k]

    def first(self) -> Estimate:
        """Return that of the first window, or raise LocationError with the reason."""
        failure = Failure(int(self.failure[0]))
        if failure != Failure.NONE:
            raise LocationError(REASONS[failure])
        x, y, amplitude, background, sigma, snr, chi2 = (
            float(each[0]) for each in (
                self.x, self.y, self.amplitude, self.background, self.sigma, self.snr, self.chi2,
            )
        )
        return Estimate(
            x, y, amplitude, background, sigma, snr, chi2, int(self.saturated[0]),
            self.covariance[0],
            self.lopsided[0].tolist() if self.lopsided.size else (), self.warnings.get(0, ''),
            self.evidence.get(0, NO_EVIDENCE), self.beside.get(0), self.drawn.get(0, 0.0),
            self.ways.get(0),
        )

    @property
    def ok(self) -> NDArray[np.bool_]:
        """(N,) bool: True where the window was located."""
        return self.failure == Failure.NONE


_ZERO = np.empty(0)
NOTHING = Estimates(  # of an empty stack
    x=_ZERO,
    y=_ZERO,
    covariance=np.empty((0, 2, 2)),
    amplitude=_ZERO,
    background=_ZERO,
    sigma=_ZERO,
    snr=_ZERO,
    chi2=_ZERO,
    saturated=np.empty(0, dtype=np.int64),
    failure=np.empty(0, dtype=np.uint8),
)


def outside(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    shape: tuple[int, ...],
    failure: NDArray[np.uint8],
) -> NDArray[np.uint8]:
    """Return the failures with OUTSIDE added where a position leaves its (N, h, w) window."""
    height, width = shape[1:]
    inside = (x >= -0.5) & (x <= width - 0.5) & (y >= -0.5) & (y <= height - 0.5)
    return np.where(inside | (failure != Failure.NONE), failure, np.uint8(Failure.OUTSIDE))
