"""
A colour of a frame: a plane of its own, or the samples behind that colour's filters.

The samples of a Bayer mosaic are not interpolated. The search takes their sum in each cell of
2 x 2 pixels, a picture binned 2 x 2; the fit takes the samples themselves, each at its own place
(`Frame.mosaic`). So the noise stays that of independent pixels, and a light of one colour stays
where it is: in a demosaiced picture, or in the sum of all four samples, a red LED moves by up to
half a pixel.

The two green samples lie across from each other: the middle of their sum is the middle of the
cell. That of the single red or blue sample is a quarter of a cell off, which costs the search
nothing and does not reach the fit.
"""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.types import BAYER, Frame, Mosaic, Pixels
import numpy as np
from numpy.typing import NDArray

COLOURS = ('red', 'green', 'blue')
CHANNELS = (*COLOURS, 'luma')
AUTO = 'auto'  # the channel in which the light is strongest
_TO_LUMA = {  # OpenCV's conversions
    'rgb': 'COLOR_RGB2GRAY',
    'bgr': 'COLOR_BGR2GRAY',
    'rgba': 'COLOR_RGBA2GRAY',
    'bgra': 'COLOR_BGRA2GRAY',
    'rggb': 'COLOR_BayerRGGB2GRAY',
    'grbg': 'COLOR_BayerGRBG2GRAY',
    'gbrg': 'COLOR_BayerGBRG2GRAY',
    'bggr': 'COLOR_BayerBGGR2GRAY',
}


def channels(frame: Frame) -> tuple[str, ...]:
    """Return the channels of a frame: none of a grey one, and of a mosaic its colours alone."""
    if frame.layout == 'grey':
        return ()
    return COLOURS if frame.layout in BAYER else CHANNELS


def in_channel(frame: Frame, channel: str) -> Frame:
    """
    Return the grey frame of one channel.

    Luma is 0.299 R + 0.587 G + 0.114 B (ITU-R BT.601), clipped where a colour is; without that
    a red light would be clipped at 76 DN and no one would know. Of a mosaic it is the green
    samples: with red and blue among them the place would depend on the light's colour.

    Parameters
    ----------
    frame : Frame
        With colours; a grey one is its own luma.
    channel : str
        One of `CHANNELS`.

    Returns
    -------
    Frame
        Grey. That of a mosaic is binned 2 x 2 and keeps its samples; an odd last row or column is
        left out.

    Raises
    ------
    ValueError
        The frame has no such channel; says why.

    """
    if frame.layout == 'grey':
        if channel != 'luma':
            raise ValueError(f'the camera is grey, it has no channel {channel}; set channel to '
                             'auto')
        return frame
    if frame.layout in BAYER:
        return _of_mosaic(frame, 'green' if channel == 'luma' else channel)
    clipped = frame.saturation
    if frame.layout == 'yuv':
        if channel == 'luma':
            image = np.ascontiguousarray(frame.image[..., 0])
        else:
            import cv2  # no part of a start, as OpenCV takes 15 ms and 30 MB

            # It wants Cr before Cb.
            colours = cv2.cvtColor(
                np.ascontiguousarray(frame.image[..., (0, 2, 1)]), cv2.COLOR_YCrCb2RGB)
            image = np.ascontiguousarray(colours[..., COLOURS.index(channel)])
            image[frame.image[..., 0] >= clipped] = clipped
    elif channel == 'luma':
        image = _luma(frame)
        image[(frame.image[..., :3] >= clipped).any(axis=-1)] = clipped
    else:
        image = np.ascontiguousarray(frame.image[..., frame.layout.index(channel[0])])
    return replace(frame, image=image, layout='grey', channel=channel)


def grey_pixels(frame: Frame, *, interpolate: bool) -> Pixels:
    """
    Return a frame's pixels without its colours, for calibrations.

    Parameters
    ----------
    frame : Frame
        Grey, or with colours.
    interpolate : bool
        Of a mosaic: its luma with all pixels, interpolated, where places count; else the first of
        the green samples of each cell, as the sensor gave it, where noise does.

    Returns
    -------
    (h, w) uint8 or uint16 array
        DN; luma of other colours in either case.

    Raises
    ------
    ValueError
        If the frame has no cell of 2 x 2.

    """
    if frame.layout not in BAYER:
        return in_channel(frame, 'luma').image
    if interpolate:
        return _luma(frame)
    return one_site(frame.image, in_channel(frame, 'green'))


def _luma(frame: Frame) -> Pixels:
    """Return OpenCV's luma of a frame with colours, of a mosaic interpolated."""
    import cv2

    return np.asarray(
        cv2.cvtColor(frame.image, getattr(cv2, _TO_LUMA[frame.layout])), frame.image.dtype
    )


def one_site(pixels: Pixels, frame: Frame) -> Pixels:
    """Return raw pixels of one kind: of each cell of a frame's mosaic the first of its colour."""
    if frame.mosaic is None:
        return pixels
    row, column = np.argwhere(frame.mosaic.sites)[0]
    return np.ascontiguousarray(pixels[row::2, column::2])


def summed(first: Pixels, second: Pixels, saturation: int) -> tuple[NDArray[np.uint16], int]:
    """
    Return the sum of two planes, clipped where either is, and the DN at which that is.

    A sum keeps all bits, and the shot noise of a sum of DN is that of a pixel with the same gain
    (electrons per DN). Sums that would need 17 bits are halved, rounded down.

    Parameters
    ----------
    first, second : (h, w) uint8 or uint16 arrays
        DN.
    saturation : int
        The DN at which a pixel of them is clipped.

    """
    one, other = first.astype(np.uint16), second.astype(np.uint16)
    clipped = np.maximum(one, other) >= saturation
    if 2 * saturation > np.iinfo(np.uint16).max:
        total, full = (one & other) + ((one ^ other) >> 1), saturation
    else:
        total, full = one + other, 2 * saturation
    total[clipped] = full
    return total, full


def _of_mosaic(frame: Frame, channel: str) -> Frame:
    """Return the samples of one colour, and their sum in each cell."""
    height, width = frame.image.shape
    if min(height, width) < 2:
        raise ValueError(f'{width} x {height} px have no cell of 2 x 2')
    pixels = frame.image[:height // 2 * 2, :width // 2 * 2]
    sites = np.array([each == channel[0] for each in frame.layout]).reshape(2, 2)
    planes = [pixels[row::2, column::2] for row, column in np.argwhere(sites)]
    saturation = frame.saturation
    image: Pixels
    if len(planes) == 1:
        image = np.ascontiguousarray(planes[0])
    else:
        image, saturation = summed(planes[0], planes[1], saturation)
    return replace(
        frame,
        image=image,
        saturation=saturation,
        stamp_ns=frame.stamp_ns + round(0.5 * frame.line_time_ns),  # of a cell's two lines
        line_time_ns=2.0 * frame.line_time_ns,
        binning=(2 * frame.binning[0], 2 * frame.binning[1]),
        layout='grey',
        channel=channel,
        mosaic=Mosaic(pixels, sites, frame.saturation),
    )
