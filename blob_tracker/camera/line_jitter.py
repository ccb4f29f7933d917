"""Line jitter of an analogue grabber: what each line is shifted by, taken off a location."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from blob_tracker.camera.yaml_file import CalibrationError, YamlFile
from blob_tracker.types import Location
import numpy as np
from numpy.typing import NDArray

MOST = 10.0  # px: a line that is further off is not jitter but lost synchronisation
REACH = 4.0  # sigma of the blob: beyond it a line holds 1e-7 of the information
_ACROSS = np.linspace(-REACH, REACH, 33)  # steps of sigma / 4: the sums are integrals to 1e-6


@dataclass(frozen=True)
class LineJitter(YamlFile):
    """
    Horizontal offset of each line of a picture (thesis, 2.2.4; Lenz and Fritsch).

    A point that is at x on the sensor is seen at x + offset in its line. The offsets are known
    up to a straight line over the picture, which is the camera matrix' principal point and skew.

    Parameters
    ----------
    offsets : (h,) array
        Mean offset of each line, px.
    sigma : (h,) array
        Standard deviation of the error of each offset, px.
    sigma_from_frame_to_frame : float
        Standard deviation of a line about its offset, independent from line to line, px.
    sigma_between_fields : float
        Standard deviation of the error that the distance of the two fields of an interlaced
        picture has, alike for all their lines, px.

    Raises
    ------
    CalibrationError
        If the arrays are of different length, or a value is invalid.

    Examples
    --------
    A line that is shifted by 0.1 px to the right has that taken off the place of a blob in it:

    >>> jitter = LineJitter(np.full(480, 0.1), np.full(480, 0.01), sigma_from_frame_to_frame=0.0)
    >>> seen = Location(320.0, 240.0, 1e-4 * np.eye(2), 150.0, 40.0, 2.0, 50.0, 1.0, 0)
    >>> round(jitter.corrected(seen, gain=40.0).x, 2)  # px
    319.9
    >>> jitter.check_height(576)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    blob_tracker.camera.yaml_file.CalibrationError: ...is for 480 lines and the picture has 576

    """

    KIND = 'line jitter'

    offsets: NDArray[np.float64]
    sigma: NDArray[np.float64]
    sigma_from_frame_to_frame: float
    sigma_between_fields: float = 0.0

    def __post_init__(self) -> None:
        if self.offsets.ndim != 1 or len(self.offsets) == 0:
            raise CalibrationError('line jitter is a list of offsets, one for each line')
        if self.sigma.shape != self.offsets.shape:
            raise CalibrationError(
                f'line jitter has {len(self.offsets)} offsets and {self.sigma.size} sigmas; '
                'it needs one of each for every line'
            )
        if not (np.abs(self.offsets) <= MOST).all():  # not true of NaN either
            raise CalibrationError(f'the offsets of lines must be within {MOST:g} px of 0')
        spread = np.append(
            self.sigma, [self.sigma_from_frame_to_frame, self.sigma_between_fields])
        if not ((spread >= 0.0) & (spread <= MOST)).all():
            raise CalibrationError(f'the sigmas of line jitter must be 0 to {MOST:g} px')

    @classmethod
    def _of_content(cls, content: dict[str, Any]) -> LineJitter:
        jitter = cls(
            offsets=np.array(content['offsets'], dtype=float),
            sigma=np.array(content['sigma'], dtype=float),
            sigma_from_frame_to_frame=float(content['sigma_from_frame_to_frame']),
            sigma_between_fields=float(content.get('sigma_between_fields', 0.0)),
        )
        jitter.check_height(int(content['image_height']))
        return jitter

    def _content(self) -> dict[str, Any]:
        return {
            'image_height': len(self.offsets),
            'sigma_from_frame_to_frame': round(self.sigma_from_frame_to_frame, 6),
            'sigma_between_fields': round(self.sigma_between_fields, 6),
            'offsets': np.round(self.offsets, 6).tolist(),
            'sigma': np.round(self.sigma, 6).tolist(),
        }

    def check_height(self, height: int) -> None:
        """Raise CalibrationError unless the picture has as many lines as were measured."""
        if height != len(self.offsets):
            raise CalibrationError(
                f'the line jitter is for {len(self.offsets)} lines and the picture has {height}'
            )

    def corrected(
        self, location: Location, *, gain: float, looks: int = 1, field: int | None = None
    ) -> Location:
        """
        Take the offset of the blob's lines off its x.

        Shifting line k of a pulse m by d_k changes its pixels by d_k dm/dx. That is odd along
        the line, so that of all parameters only x follows, and in maximum likelihood it does so
        by the mean of the shifts, weighted with the information on x that each line holds:

            dx = sum_k w_k d_k / sum_k w_k,    w_k = sum_j (dm_kj/dx)^2 / v_kj

        For constant noise w_k is exp(-(k - y)^2 / sigma^2); where shot noise rules it is the
        wider exp(-(k - y)^2 / 2 sigma^2). Here v = v_0 + (m - b) / gain, with v_0 from the SNR of
        the location. The variance of x grows by that of the weighted mean: offsets and jitter
        are independent from line to line, so that w has an effective number of lines
        (sum w)^2 / sum w^2, sqrt(2 pi) sigma for constant noise. A field has half of them: line k
        of the picture, which is its own, covers k and k + 1 and lies half a line below k.

        Parameters
        ----------
        location : Location
            As located; in full-frame px.
        gain : float
            Electrons per DN, as it was located with.
        looks : int
            Frames that were summed in the window: the jitter from frame to frame averages out.
        field : int or None
            Which field of an interlaced picture the blob was seen in: 0 has the even lines, 1 the
            odd ones. None of a whole picture.

        Returns
        -------
        Location
            With x and its variance changed.

        """
        first, step = (0, 1) if field is None else (field, 2)
        # In lines of the picture: a round light is an ellipse in those of a field, whose size is
        # the geometric mean of its axes. A pixel is a box: its variance adds.
        sigma = np.sqrt(step * location.sigma**2 + step**2 / 12.0)
        lines = np.arange(first, len(self.offsets), step)
        places = lines + 0.5 * (step - 1)
        near = np.abs(places - location.y) < REACH * sigma + step
        lines, places = lines[near], places[near]
        down = np.exp(-0.5 * ((places - location.y) / sigma) ** 2)
        shot = location.amplitude / gain
        unlit = max((location.amplitude / location.snr) ** 2 - shot, 1.0 / 12.0)
        across = np.exp(-0.5 * _ACROSS**2)
        variance = unlit + shot * np.outer(down, across)
        weights = down**2 * ((_ACROSS * across) ** 2 / variance).sum(axis=1)
        weights /= weights.sum()
        spread = self.sigma[lines] ** 2 + self.sigma_from_frame_to_frame**2 / looks
        covariance = location.covariance.copy()
        covariance[0, 0] += weights**2 @ spread
        if field is not None:
            # A straight line over all of them is in the middle between the two.
            covariance[0, 0] += (0.5 * self.sigma_between_fields) ** 2
        return replace(
            location, x=location.x - float(weights @ self.offsets[lines]), covariance=covariance
        )
