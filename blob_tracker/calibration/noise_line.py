"""The line of variance against level: its slope is 1 / gain, its foot the read noise."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, sqrt

from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

QUANTISATION = 1.0 / 12.0  # DN^2, of rounding to whole DN
ITERATIONS = 8  # the weights follow the line; after 4 it stands still to 1e-6 of its sigma
MISFIT = 0.01  # probability below which points beside the line are no chance
SEPARABLE = 0.1  # sigma of a slope over the slope, beyond which it tells no gain


@dataclass(frozen=True)
class NoiseLine:
    """
    Temporal variance of a pixel over its level, v(m) = foot + slope m.

    Parameters
    ----------
    slope : float
        K, DN per electron.
    foot : float
        v(0), DN^2: read_noise^2 + 1/12 - slope black_level, the black level over the same level.
    covariance : (2, 2) array
        Of slope and foot.
    chi2 : float
        Squared residuals over their variance, of all points.
    dof : int
        Points less 2.
    fits : bool
        Whether the points lie on a line as far as chance lets them; else sigmas have grown.

    """

    slope: float
    foot: float
    covariance: NDArray[np.float64]
    chi2: float
    dof: int
    fits: bool = True

    @property
    def separates(self) -> bool:
        """Whether the levels span enough to tell the gain from the read noise."""
        return self.slope > 0.0 and sqrt(self.covariance[0, 0]) < SEPARABLE * self.slope

    @property
    def gain(self) -> float:
        """1 / K, electrons per DN; infinite where the slope is not above 0."""
        return 1.0 / self.slope if self.slope > 0.0 else inf

    @property
    def read_noise(self) -> float:
        """Read noise before quantisation if level 0 is black: DN, 0 for a foot below 1/12."""
        return sqrt(max(self.foot - QUANTISATION, 0.0))

    @property
    def noise(self) -> SensorNoise:
        """
        Noise whose variance is this line.

        The line does not tell read noise and black level apart: every pair of one foot is the
        same noise. Here the black level is 0, and where no read noise has so low a foot it is the
        least that has, (1/12 - foot) gain, with no read noise.
        """
        black_level = 0.0
        if self.slope > 0.0:
            black_level = max(QUANTISATION - self.foot, 0.0) / self.slope
        return SensorNoise(self.gain, self.read_noise, black_level)

    @property
    def noise_covariance(self) -> NDArray[np.float64]:
        """
        (2, 2) covariance of gain, e-/DN, and read noise, DN.

        To first order, J C J^T with d gain / d slope = -gain^2 and d read_noise / d foot =
        1 / (2 read_noise). Towards no read noise at all that grows without end: the read noise in
        it is taken as sqrt(s) / 2 at least, with s the sigma of the foot, so that its own sigma is
        sqrt(s) at most. The squared error over it is 0.9 to 1.15 in the mean where the foot is a
        quarter of s above 1/12 or more.
        """
        s = sqrt(self.covariance[1, 1])
        root = max(self.read_noise, 0.5 * sqrt(s))
        jacobian = np.diag([-self.gain**2, 0.5 / root if root > 0.0 else 0.0])
        return np.asarray(jacobian @ self.covariance @ jacobian.T)

    def turned(self, slope: float) -> NoiseLine:
        """
        Return the line with a sigma of its slope that is no smaller than the way to another one.

        A response that bends takes neighbouring points off to one side, and the slope depends on
        what each level weighs: the weights of the fit favour the dark ones. Two slopes of the same
        points tell how much. The line is turned about its middle, the level at which slope and
        height are apart.

        Parameters
        ----------
        slope : float
            Of the same points with other weights.

        """
        least = (slope - self.slope) ** 2
        known = float(self.covariance[0, 0])
        if known <= 0.0 or least <= known:
            return self
        turn = np.array([1.0, self.covariance[0, 1] / known])
        return replace(self, covariance=self.covariance + (least - known) * np.outer(turn, turn))

    def variance(self, level: float) -> tuple[float, float]:
        """Return the variance of a pixel at a level, DN^2, and its standard deviation."""
        row = np.array([level, 1.0])
        return self.foot + self.slope * level, sqrt(row @ self.covariance @ row)


def fit_noise_line(
    levels: NDArray[np.float64],
    variances: NDArray[np.float64],
    scatters: NDArray[np.float64],
) -> NoiseLine:
    """
    Fit v = foot + slope m, each point weighted by the known variance of a variance.

    The variance of a sample variance s^2 over n values is (kurtosis - 1) sigma^4 / n, for Gaussian
    noise 2 sigma^4 / n. The sigma^4 in it is that of the line, not of the point: a point that is
    low by chance must not weigh more.

    Where the points do not lie on a line (chi2 beyond its 99 % bound) their variances, and with
    them the covariance, grow by chi2 per degree of freedom: that of their shot noise and that of
    the rest each by its own, so that many dark points that agree hide no bright ones that do not.
    That is all where each point is off by itself; for a bend see `NoiseLine.turned`.

    Parameters
    ----------
    levels, variances : (n,) arrays
        DN and DN^2.
    scatters : (n,) array
        Variance of each variance over its own square: (kurtosis - 1) / n.

    Returns
    -------
    NoiseLine
        The line.

    Raises
    ------
    ValueError
        If there are fewer than two levels that differ.

    """
    if levels.size < 2 or not np.ptp(levels) > 0.0:
        raise ValueError(f'{levels.size} points at one level; a line needs two levels or more')
    expected = variances
    covariance = back = np.empty((2, 2))
    line = np.empty(2)
    for _ in range(ITERATIONS):
        weights = 1.0 / (scatters * np.maximum(expected, 0.5 * QUANTISATION) ** 2)
        # About the mean level slope and height are apart: nothing is lost to a large level.
        middle = float(np.average(levels, weights=weights))
        away = levels - middle
        slope = float((weights * away * variances).sum() / (weights * away**2).sum())
        height = float(np.average(variances, weights=weights))
        line = np.array([slope, height - slope * middle])
        apart = np.diag([1.0 / (weights * away**2).sum(), 1.0 / weights.sum()])
        back = np.array([[1.0, 0.0], [-middle, 1.0]])
        covariance = back @ apart @ back.T
        expected = line[1] + line[0] * levels
    weights = 1.0 / (scatters * np.maximum(expected, 0.5 * QUANTISATION) ** 2)
    squares = weights * (variances - expected) ** 2
    chi2, dof = float(squares.sum()), levels.size - 2
    # The part of a point's variance that grows with the level.
    shot = np.clip(line[0] * levels / np.maximum(expected, 0.5 * QUANTISATION), 0.0, 1.0)
    grown = 1.0 + sum(
        part * (_misfit(float(part @ squares), dof * float(part.mean())) - 1.0)
        for part in (shot, 1.0 - shot)
    )
    if np.all(grown == 1.0):
        return NoiseLine(slope, float(line[1]), covariance, chi2, dof)
    apart = np.diag([
        (weights * grown * away**2).sum() / (weights * away**2).sum() ** 2,
        (weights * grown).sum() / weights.sum() ** 2,
    ])
    crossed = (weights * grown * away).sum() / (weights * away**2).sum() / weights.sum()
    apart[0, 1] = apart[1, 0] = crossed
    return NoiseLine(slope, float(line[1]), back @ apart @ back.T, chi2, dof, fits=False)


def _misfit(chi2: float, dof: float) -> float:
    """Return chi2 per degree of freedom where it is no chance, and 1 where it may be."""
    import scipy  # no part of a start; stats takes half a second to load

    if dof <= 0.0 or scipy.special.chdtrc(dof, chi2) >= MISFIT:
        return 1.0
    return chi2 / dof
