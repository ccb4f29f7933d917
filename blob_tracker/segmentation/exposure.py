"""Frames in which no target could be seen: dark, blown out, or no picture at all."""

from __future__ import annotations

from blob_tracker.types import Frame
import numpy as np

DARK_FRACTION = 1 / 64  # of full scale: no light that can be placed is fainter, whatever the noise
CLIPPED_FRACTION = 0.5  # of the pixels


def exposure_fault(frame: Frame) -> str:
    """
    Say what is wrong with a frame's exposure.

    Parameters
    ----------
    frame : Frame
        The frame.

    Returns
    -------
    str
        Empty where a target could be seen in it.

    Examples
    --------
    >>> exposure_fault(Frame(np.full((48, 64), 255, np.uint8), stamp_ns=0, saturation=255))
    '100 % of the pixels are clipped at 255 DN: the exposure is far too long'

    """
    image, full = frame.image, frame.saturation
    brightest = int(image.max())
    if brightest < DARK_FRACTION * full:
        return (
            f'the brightest pixel is {brightest} DN of {full}: is the lens cap on? The exposure '
            'is far too short otherwise'
        )
    clipped = float(np.count_nonzero(image >= full)) / image.size
    if clipped > CLIPPED_FRACTION:
        return (
            f'{100 * clipped:.0f} % of the pixels are clipped at {full} DN: the exposure is far '
            'too long'
        )
    if brightest == int(image.min()):
        return f'every pixel is {brightest} DN: the camera gives no picture'
    return ''
