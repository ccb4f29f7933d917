"""What the scatter about a fit says of the sigmas that went into it."""

from __future__ import annotations

from scipy.stats import chi2 as chi_square

IMPROBABLE = 1e-3  # of a chi-square this large or larger, where the sigmas are right


def variance_factor(chi2: float, freedom: int, *, known: bool) -> float:
    """
    Return what the covariance of a fit is to be multiplied by.

    Where the sigmas of the measurements are known, they say how uncertain the parameters are,
    and the scatter only has a voice if it cannot be theirs; else the scatter is all there is.

    Parameters
    ----------
    chi2 : float
        Sum of the squared residuals over their variances.
    freedom : int
        Measured values less fitted parameters, 1 or more.
    known : bool
        Whether the variances are known, or only in proportion.

    Returns
    -------
    float
        1, or chi2 / freedom.

    """
    if known and chi_square.sf(chi2, freedom) >= IMPROBABLE:
        return 1.0
    if known and chi2 < freedom:
        return 1.0
    return chi2 / freedom
