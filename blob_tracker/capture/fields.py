"""An interlaced picture -> its two fields, each a frame with a time of its own."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.types import BAYER, Frame
import numpy as np

TOP, BOTTOM = 0, 1
# How a picture holds its fields, as V4L2_FIELD_... names it, in the order of time: the fields, and
# whether they lie line by line or one above the other.
ORDERS: dict[str, tuple[tuple[int, ...], bool]] = {
    'interlaced_tb': ((TOP, BOTTOM), True),
    'interlaced_bt': ((BOTTOM, TOP), True),
    'seq_tb': ((TOP, BOTTOM), False),
    'seq_bt': ((BOTTOM, TOP), False),
    'top': ((TOP,), False),
    'bottom': ((BOTTOM,), False),
}
LINES_OF_525 = (480, 486)  # of a picture by the standard of 525 lines, which begins at the bottom


def order_of(name: str, height: int) -> str:
    """
    Return the key of `ORDERS` for a V4L2 field order.

    Parameters
    ----------
    name : str
        One of `ORDERS`, or 'interlaced', whose order is that of the video standard: bottom first
        with 525 lines, top first with 625.
    height : int
        Lines of the picture.

    Raises
    ------
    ValueError
        Where there is no such order.

    """
    if name == 'interlaced':
        return 'interlaced_bt' if height in LINES_OF_525 else 'interlaced_tb'
    if name not in ORDERS:
        raise ValueError(f"no field order '{name}'; there is interlaced, {', '.join(ORDERS)}")
    return name


def fields(frame: Frame, order: str, interval_ns: int) -> tuple[Frame, ...]:
    """
    Deal the fields of a picture out.

    Line u of a field is taken to cover the lines o + 2 u and o + 2 u + 1 of the picture, as a
    camera sums them that integrates fields: o is 0 at the top and 1 at the bottom, the binning
    along y is 2, and y = y0 + 2 (u + 1/2) - 1/2. The last line of the bottom field, which reaches
    beyond the picture, is left out, and that of the top field, so that both have one size. So
    places are half a line below those in whole pictures, in which the line has the number
    o + 2 u: a calibration of whole pictures is that of the fields with half a line more in c_y.

    Parameters
    ----------
    frame : Frame
        The picture. Its stamp is the middle of the exposure of the first line of the field that
        was taken first, its line time that from a line of a field to the next of the same field.
        A picture in the order 'top' or 'bottom' is a field alone, its place and binning are those
        of the whole.
    order : str
        One of `ORDERS`, or 'interlaced': see `order_of`.
    interval_ns : int
        From picture to picture, ns: the second field is half of it later.

    Returns
    -------
    tuple of Frame
        In the order of time.

    Raises
    ------
    ValueError
        Where there is no such order, the picture has fewer than four lines, or it is a mosaic.

    """
    if frame.layout in BAYER or frame.mosaic is not None:
        raise ValueError('the lines of a Bayer mosaic are no fields; have the camera give grey')
    height = frame.image.shape[0]
    if height < 4:
        raise ValueError(f'a picture of {height} lines has no fields')
    kinds, woven = ORDERS[order_of(order, height)]
    dealt = []
    for place, kind in enumerate(kinds):
        if woven:
            image, lines = frame.image[kind::2], height
        else:
            rows = height // len(kinds)
            image, lines = frame.image[place * rows:(place + 1) * rows], 2 * rows
        across, down = frame.binning
        dealt.append(replace(
            frame,
            image=np.ascontiguousarray(image[:(lines - 1) // 2]),
            stamp_ns=frame.stamp_ns + place * (interval_ns // 2),
            y0=frame.y0 + kind * down,
            binning=(across, 2 * down),
        ))
    return tuple(dealt)
