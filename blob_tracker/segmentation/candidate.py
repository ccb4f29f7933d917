"""Something that lit up, and what it is measured by."""

from __future__ import annotations

from typing import NamedTuple

from blob_tracker.types import Glimpse, Pixels


class Candidate(NamedTuple):
    """
    Something that lit up.

    Parameters
    ----------
    x, y : float
        Centre, px of the frame as it is (crop and binning left aside).
    sigma_x, sigma_y : float
        Standard deviations along the rows and the columns, px.
    sigma_major, sigma_minor : float
        Those along the longest and the shortest axis, px.
    correlation : float
        Of x and y.
    snr : float
        Response of the matched filter in standard deviations of its noise.
    background : float
        Lit less unlit about it, DN.
    column, row : float
        Pixel of the peak; whole numbers.
    height : float
        Rise of that pixel above the background of the frame, DN.
    amplitude : float
        Height of the Gaussian that fits best, DN.
    misfit : float
        What of it the Gaussian does not explain, nor the noise, nor that it is round where it is
        wide: rms over rms of the Gaussian.
    neighbour_ratio : float
        Mean rise of the four neighbours of the peak, as a part of the peak's.
    fall : float
        Greatest loss of light in a square of 2 sigma within 9 sigma of it, DN.
    unlit_amplitude : float
        That of the blob that was there before it lit up, DN.
    texture : float
        Standard deviation of the scene about it before it lit up, DN.
    clipped : float
        Whether pixels were clipped there before; 0 or 1.
    noise : float
        Standard deviation of lit less unlit in that part of the frame, DN.
    surround_noise : float
        Standard deviation of lit less unlit within 9 sigma about it, DN.
    streak : float
        Whether it is an even line with two ends, as of a light that moves; 0 or 1.
    rejected : str
        Why it is no target; empty if it may be one.
    tau : float
        When it was seen, s from the frame's stamp.
    glimpse : Glimpse or None
        How it was seen if it blinks, px of the frame as it is.
    unlit : (h, w) array or None
        Raw frame in which it was dark, where that is one of its own.

    Examples
    --------
    What lit up in the last frame of two of the virtual lab:

    >>> from blob_tracker.segmentation import Segmenter
    >>> from blob_tracker.simulation import flashing_light
    >>> from blob_tracker.types import Frame
    >>> scene, segmenter = flashing_light(width=160, height=120), Segmenter()
    >>> for index in (1, 2):
    ...     _ = segmenter.update(Frame(scene.frame(index), scene.stamp_ns(index), saturation=255))
    >>> light = segmenter.detections.candidates[0]
    >>> round(light.x), round(light.y), round(light.sigma_x), light.peak  # px
    (82, 82, 2, (82, 82))
    >>> round(scene.truth(2).x), round(scene.truth(2).y)
    (82, 82)

    """

    x: float
    y: float
    sigma_x: float
    sigma_y: float
    sigma_major: float
    sigma_minor: float
    correlation: float
    snr: float
    background: float
    column: float
    row: float
    height: float
    amplitude: float
    misfit: float
    neighbour_ratio: float
    fall: float
    unlit_amplitude: float
    texture: float
    clipped: float
    noise: float
    surround_noise: float = 0.0
    streak: float = 0.0
    rejected: str = ''
    tau: float = 0.0
    glimpse: Glimpse | None = None
    unlit: Pixels | None = None

    @property
    def peak(self) -> tuple[int, int]:
        """Column and row of the brightest pixel."""
        return int(self.column), int(self.row)
