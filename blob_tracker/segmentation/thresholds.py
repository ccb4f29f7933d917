"""The ways to find the window about a peak, by name."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from inspect import signature

from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.histogram import histogram
from blob_tracker.segmentation.histogram_extended import histogram_extended
from blob_tracker.segmentation.histogram_shortened import histogram_shortened
from blob_tracker.segmentation.otsu import otsu_window
from blob_tracker.segmentation.sigma_window import sigma_window

# (contrast, candidate, largest half-width) -> the window, None if there is none.
Threshold = Callable[[Contrast, Candidate, int], Box | None]
THRESHOLDS: dict[str, Callable[..., Box | None]] = {
    'sigma_window': sigma_window,
    'otsu_window': otsu_window,
    'histogram': histogram,
    'histogram_extended': histogram_extended,
    'histogram_shortened': histogram_shortened,
}


def threshold_by_name(method: str, *, sigmas: float, extension: int) -> Threshold:
    """
    Return a threshold method with the options that it has.

    Parameters
    ----------
    method : str
        A key of `THRESHOLDS`.
    sigmas : float
        Half-width of `sigma_window`, in standard deviations of the blob.
    extension : int
        Pixels that `histogram_extended` adds on each side.

    Returns
    -------
    callable
        From contrast, candidate and greatest half-width to the window.

    Raises
    ------
    ValueError
        If there is no such method.

    Examples
    --------
    >>> threshold = threshold_by_name('sigma_window', sigmas=3.0, extension=2)
    >>> threshold.keywords
    {'sigmas': 3.0}
    >>> threshold_by_name('median', sigmas=3.0, extension=2)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    ValueError: no threshold method 'median'; there is sigma_window, otsu_window, ...

    """
    if method not in THRESHOLDS:
        raise ValueError(f"no threshold method '{method}'; there is {', '.join(THRESHOLDS)}")
    function = THRESHOLDS[method]
    options = {'sigmas': sigmas, 'extension': extension}
    known = signature(function).parameters
    return partial(function, **{name: options[name] for name in options if name in known})
