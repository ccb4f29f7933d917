"""Trailing edge of an analogue camera: what its filter makes of a line, and the way back."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

from blob_tracker.camera.yaml_file import CalibrationError, YamlFile
from blob_tracker.types import Window
import numpy as np
from numpy.typing import NDArray

MOST_PEAKING = 10.0  # a camera that boosts its edges further shows no picture
MOST_MEMORY = 200.0  # px: what is longer tilts whole lines and is no edge any more
DOUBT = 0.5  # DN: what is known to the rounding is as good as known


def fading_mean(lines: NDArray[np.float64], memory: float) -> NDArray[np.float64]:
    """
    Return the mean of what came before in each line, see `TrailingEdge`.

    Parameters
    ----------
    lines : (..., w) array
        Lines along the last axis; 0 came before the first pixel.
    memory : float
        Pixels in which it fades to 1/e.

    Returns
    -------
    (..., w) array
        m_k, with m_k+1 = e m_k + (1 - e) x_k and e = exp(-1 / memory).

    Examples
    --------
    A step, and what came before each pixel of it:

    >>> step = np.array([0.0, 0.0, 100.0, 100.0, 100.0, 100.0])
    >>> fading_mean(step, memory=1.0).round(1).tolist()
    [0.0, 0.0, 0.0, 63.2, 86.5, 95.0]

    """
    import scipy  # no part of a start

    kept = np.exp(-1.0 / memory)
    return np.asarray(scipy.signal.lfilter([0.0, 1.0 - kept], [1.0, -kept], lines, axis=-1))


@dataclass(frozen=True)
class TrailingEdge(YamlFile):
    """
    Over-peaking of the lines of a camera's video signal (thesis, Figure 5.3 and section 6.1).

    A camera raises what changes fast, to make up for the aperture of its cells. Its filter knows
    the past alone, the mean m of what came before in the line, which fades over some pixels:

        y_k = x_k + a (x_k - m_k),   m_k+1 = e m_k + (1 - e) x_k,   e = exp(-1 / tau)

    and what falls below black is clipped. An even area is left as it is (m = x).

    Parameters
    ----------
    peaking : float
        a: overshoot of a step, as a part of it; 0 is a camera without peaking.
    memory : float
        tau: the overshoot falls to 1/e in so many pixels, px.
    covariance : (2, 2) array
        Of peaking and memory, as they were measured; -, px, px^2.

    Raises
    ------
    CalibrationError
        If a value is invalid.

    Examples
    --------
    A step that a camera has raised by a fifth, and as it was:

    >>> step = np.array([[0.0, 0.0, 100.0, 100.0, 100.0, 100.0]])
    >>> seen = step + 0.2 * (step - fading_mean(step, memory=1.0))
    >>> seen.round().tolist()
    [[0.0, 0.0, 120.0, 107.0, 103.0, 101.0]]
    >>> restored, _ = TrailingEdge(peaking=0.2, memory=1.0).restored(seen)
    >>> restored.round().tolist()
    [[0.0, 0.0, 100.0, 100.0, 100.0, 100.0]]

    """

    KIND = 'trailing edge'

    peaking: float
    memory: float
    covariance: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        if not 0.0 <= self.peaking <= MOST_PEAKING:  # not true of NaN either
            raise CalibrationError(f'peaking is {self.peaking}; it must be 0 to {MOST_PEAKING:g}')
        if not (isfinite(self.memory) and 0.0 < self.memory <= MOST_MEMORY):
            raise CalibrationError(
                f'memory is {self.memory} px; it must be above 0 and up to {MOST_MEMORY:g} px'
            )
        if self.covariance is not None and not (
            self.covariance.shape == (2, 2) and np.isfinite(self.covariance).all()
            and (np.diag(self.covariance) >= 0.0).all()
        ):
            raise CalibrationError('the covariance of peaking and memory is 2 x 2 and finite')

    @classmethod
    def _of_content(cls, content: dict[str, Any]) -> TrailingEdge:
        covariance = content.get('covariance')
        return cls(
            peaking=float(content['peaking']),
            memory=float(content['memory']),
            covariance=None if covariance is None else np.array(covariance, dtype=float),
        )

    def _content(self) -> dict[str, Any]:
        content: dict[str, Any] = {'peaking': self.peaking, 'memory': self.memory}
        if self.covariance is not None:
            content['covariance'] = self.covariance.tolist()
        return content

    def restored(
        self, pixels: NDArray[Any], saturation: float | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """
        Return the lines as they were before the camera's filter, and how far they are in doubt.

        Above black the filter is linear and is undone pixel by pixel,

            x_k = (y_k + a m_k) / (1 + a)

        with m_k from the x before. The memory of the first pixel is taken to be what it shows,
        the background. Of a pixel clipped at black only 0 <= x_k <= a m_k / (1 + a) is known: the
        middle is taken, half the range is its doubt, and the memory carries the doubt on,

            d_k = a D_k / (1 + a),   D_k+1 = e D_k + (1 - e) d_k

        to the pixels after it, until it has faded. A clipped bright pixel is in doubt by as much
        as it shows.

        Parameters
        ----------
        pixels : (h, w) array
            DN above black, the lines along the second axis.
        saturation : float or None
            DN at which a bright pixel is clipped.

        Returns
        -------
        signal, doubt : (h, w) arrays
            DN; the doubt is a bound, not a standard deviation, and holds no noise.

        """
        seen = np.asarray(pixels, dtype=float)
        kept = float(np.exp(-1.0 / self.memory))
        share = self.peaking / (1.0 + self.peaking)
        signal, doubt = np.empty_like(seen), np.empty_like(seen)
        black = seen <= 0.0
        white = seen >= (np.inf if saturation is None else saturation)
        memory, carried = seen[:, 0].copy(), np.zeros(len(seen))
        for k in range(seen.shape[1]):
            most = share * memory
            x = np.where(black[:, k], 0.5 * most, seen[:, k] / (1.0 + self.peaking) + most)
            d = share * carried
            d = np.where(black[:, k], 0.5 * most + d, d)
            d = np.where(white[:, k], np.abs(seen[:, k]), d)
            signal[:, k], doubt[:, k] = x, d
            memory = kept * memory + (1.0 - kept) * x
            carried = kept * carried + (1.0 - kept) * d
        return signal, doubt

    def corrected(self, window: Window) -> Window:
        """
        Undo the filter in a window, ahead of locating.

        Where pixels were clipped at black, only columns are kept that are known to half a DN,
        and as many on either side of the brightest pixel: what is left is even-sided, and a blob
        that is not quite the Gaussian that is fitted to it does not lean to the side that is
        longer. Noise that came before the filter is restored with the light; what came after it
        is damped by up to 1 + a, and the covariance, which knows the pixels alone, is then wide.

        Parameters
        ----------
        window : Window
            Raw, black at 0 DN. Its left side must lie on the background, some 6 sigma from the
            blob: what a tail ahead of it left in the memory cannot be known.

        Returns
        -------
        Window
            In DN as before, not rounded, perhaps narrower. A pixel that was clipped as too bright
            is still at the saturation or above it.

        """
        least = DOUBT * window.looks
        bright = window.saturation
        lit, doubt = self.restored(window.lit, bright)
        if bright is not None:
            clipped = np.asarray(window.lit) >= bright
            # What is restored may be above full scale and yet not clipped.
            bright = max(bright, 1.0 + float(lit[~clipped].max(initial=0.0)))
            lit[clipped] = bright
            doubt[clipped] = 0.0  # of themselves, as nothing reads them; what they left stays
        unlit = window.unlit
        if unlit is not None:
            unlit, dark_doubt = self.restored(unlit, window.saturation)
            doubt = np.maximum(doubt, dark_doubt)
        column = int(np.argmax(np.asarray(window.lit).max(axis=0)))
        doubtful = np.flatnonzero((doubt > least).any(axis=0))
        first, last = 0, lit.shape[1]
        if doubtful.size:
            reach = int(np.abs(doubtful - column)[doubtful != column].min(initial=last)) - 1
            first, last = max(column - reach, 0), min(column + reach + 1, last)
        return replace(
            window,
            lit=lit[:, first:last],
            unlit=None if unlit is None else unlit[:, first:last],
            x0=window.x0 + first * window.binning[0],
            saturation=bright,
        )
