"""Pictures of an analogue grabber, whose lines do not all begin at the same place."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
import scipy  # which loads special, 20 MB, when it is first used

SHIFT_PX = 0.25  # px from the top to the bottom of a field (thesis, Figure 2.4)
SETTLED_LINES = 150  # lines of a field after which most of it is over (thesis, 2.2.4)
REMAINDER_PX = 0.05  # px, what is left from frame to frame: 1/20 (Lenz and Fritsch)


def line_offsets(
    height: int, *, fields: int = 2, between_fields: float = 0.02
) -> NDArray[np.float64]:
    """
    Return the mean horizontal offset of each line, as thesis Figure 2.4 shows it.

    The lines of a field drift towards a limit, after SETTLED_LINES lines to within 5 % of
    SHIFT_PX:

        offset = -SHIFT_PX exp(-3 line / SETTLED_LINES)

    Parameters
    ----------
    height : int
        Lines of the picture.
    fields : int
        2 where odd and even lines come one field after the other, 1 where they do not.
    between_fields : float
        Offset of the second field, px.

    Returns
    -------
    (h,) array
        px; a point at x is seen at x + offset.

    """
    lines = np.arange(height)
    in_field = lines // fields
    return -SHIFT_PX * np.exp(-3.0 * in_field / SETTLED_LINES) + between_fields * (lines % fields)


def draw_edge(
    shape: tuple[int, int],
    places: NDArray[np.float64],
    sigma: float,
    dark: float,
    bright: float,
) -> NDArray[np.float64]:
    """
    Return the mean signal of a blurred vertical edge, integrated over each pixel.

    With G(t) the integral of the unit step blurred by a Gaussian, G(t) = t Phi(t / sigma) +
    sigma phi(t / sigma), pixel k of a line whose edge is at x has

        dark + (bright - dark) [G(k + 1/2 - x) - G(k - 1/2 - x)]

    Parameters
    ----------
    shape : (int, int)
        Height and width, px.
    places : (h,) array
        x of the edge in each line, px.
    sigma : float
        Standard deviation of the blur, px.
    dark, bright : float
        Signal to the left and to the right of the edge, DN.

    Returns
    -------
    (h, w) array
        DN.

    """
    height, width = shape
    borders = np.arange(width + 1) - 0.5 - np.reshape(places, (height, 1))
    scaled = borders / sigma
    phi = np.exp(-0.5 * scaled**2) / np.sqrt(2.0 * np.pi)
    integral = borders * 0.5 * (1.0 + scipy.special.erf(scaled / np.sqrt(2.0))) + sigma * phi
    return dark + (bright - dark) * np.diff(integral, axis=1)


def displaced_lines(
    mean: NDArray[np.floating], offsets: NDArray[np.float64]
) -> NDArray[np.float64]:
    """
    Return a picture whose lines are seen at an offset, by cubic splines along each.

    Parameters
    ----------
    mean : (h, w) array
        Mean signal, DN.
    offsets : (h,) array
        px; what was at x is seen at x + offset. What comes in from beyond the border is as the
        border pixel.

    Returns
    -------
    (h, w) array
        DN; within 1 % of the peak of a Gaussian of sigma 1 px, within 3e-4 at 2.5 px.

    """
    height, width = mean.shape
    across = np.arange(width) - np.reshape(offsets, (height, 1))
    spline = scipy.ndimage.spline_filter1d(
        np.asarray(mean, dtype=float), order=3, axis=1, mode='nearest'
    )
    picture = np.empty((height, width))
    for row in range(height):
        picture[row] = scipy.ndimage.map_coordinates(
            spline[row], [across[row]], order=3, mode='nearest', prefilter=False
        )
    return picture


def jittering_offsets(
    offsets: NDArray[np.float64],
    random: np.random.Generator,
    *,
    per_line: float = REMAINDER_PX,
    per_frame: float = 0.0,
) -> NDArray[np.float64]:
    """
    Draw the offsets of the lines of one frame about their mean.

    Parameters
    ----------
    offsets : (h,) array
        Mean offsets, px, as of `line_offsets`.
    random : Generator
        Source of the jitter.
    per_line : float
        Standard deviation of each line, independent of the others, px.
    per_frame : float
        Standard deviation of the start of all the frame's lines together, px: of a grabber whose
        oscillator finds the pulse at the frame's start anew.

    Returns
    -------
    (h,) array
        px.

    """
    together = per_frame * random.standard_normal()
    return offsets + together + per_line * random.standard_normal(offsets.shape)
