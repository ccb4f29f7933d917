"""The lens model rational_polynomial: with a denominator, a prism and a tilt, of wide lenses."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

from blob_tracker.camera.lens import plumb_bob
from blob_tracker.camera.lens.definition import Lens, Start
from blob_tracker.camera.lens.polynomial import COUNTS, image, project, ray, slopes
import numpy as np
from numpy.typing import NDArray

DENOMINATOR = ('k4', 'k5', 'k6')
# Sigma to which its coefficients are held about 0, as part of the covariance: without it numerator
# and denominator find a common root inside of the image now and then, and bend the picture there
# to fit the noise.
DENOMINATOR_SIGMA = 1.0


def start(
    points: Sequence[NDArray[np.float64]],
    places: Sequence[NDArray[np.float64]],
    size: tuple[int, int],
) -> Start:
    """Return the fit without a denominator."""
    found = plumb_bob.start(points, places, size)
    return found._replace(coefficients=np.append(found.coefficients, np.zeros(len(DENOMINATOR))))


LENS = Lens(
    counts=COUNTS,
    image=image,
    ray=ray,
    names=(*plumb_bob.NAMES, *DENOMINATOR),
    start=start,
    project=project,
    slopes=slopes,
    sigmas=(*(inf for _ in plumb_bob.NAMES), *(DENOMINATOR_SIGMA for _ in DENOMINATOR)),
)
