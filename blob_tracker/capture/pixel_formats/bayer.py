"""
Bayer: the sum of the two green samples of each cell of 2 x 2 pixels; the picture is binned 2 x 2.

Why the green ones, why their sum, and why one for each cell:

- They lie across from each other, so that the middle of what is added is the middle of the cell,
  whatever the colour of the light. With red and blue in it, the middle would move by
  (b - r) / (2 (r + 2 g + b)) px for a light that gives r, g and b: a third of a pixel for a red
  LED. The two places, 0.7 px from the middle, widen the blob along one diagonal; as this is
  symmetric it does not move it.
- A sample is used once: pixels of the picture stay independent. Interpolated ones share samples,
  so that a covariance from their noise would be wrong. A sum keeps all bits, and the shot noise
  of a sum of DN is that of a pixel with the same gain (electrons per DN); its read noise is
  sqrt(2) times a sample's.
- Where one of the two is clipped, so is their sum: it is set to `saturation`, twice a sample's.

Sums of 16-bit samples would need 17 bits: they are halved (rounded down), which doubles the gain.

Frame.binning is (2, 2) times that of the camera, x0 and y0 are unchanged, and camera_info keeps
the size of the full sensor with binning_x = binning_y = 2: pixel x of the picture has its middle
at x0 + 2 (x + 0.5) - 0.5, between the two samples. An odd last row or column is left out.

Green passes near infrared as the other two do, and white light; of a deep red light it sees
a tenth or less: for that the red samples are there, which this picture leaves out and
`PixelFormat.colours` does not.
"""

from __future__ import annotations

from functools import partial

from blob_tracker.capture.pixel_formats.pixel_format import Decoder, PixelData
from blob_tracker.colour import summed
from blob_tracker.types import Pixels
import numpy as np
from numpy.typing import NDArray


def green(samples: Decoder, first: int, bits: int) -> Decoder:
    """
    Return the decoder of a Bayer format.

    Parameters
    ----------
    samples : function
        Decoder of all samples, as if they were grey.
    first : int
        Column of the first row's first green sample: 0 for GRBG and GBRG, 1 for RGGB and BGGR.
    bits : int
        Of a sample, 8 to 16.

    """
    return partial(_green, samples=samples, first=first, bits=bits)


def _green(
    data: PixelData, width: int, height: int, stride: int, *,
    samples: Decoder, first: int, bits: int,
) -> NDArray[np.uint16]:
    if width < 2 or height < 2:
        raise ValueError(f'{width}x{height} pixels have no cell of 2 x 2')
    every: Pixels = samples(data, width, height, stride)
    every = every[:height // 2 * 2, :width // 2 * 2]
    total, _ = summed(every[::2, first::2], every[1::2, 1 - first::2], (1 << bits) - 1)
    return total


def saturation(bits: int) -> int:
    """Return the DN at which the sum of two samples of so many bits is clipped."""
    return 65535 if bits == 16 else 2 * ((1 << bits) - 1)
