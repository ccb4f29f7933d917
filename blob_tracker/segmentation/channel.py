"""Which colour of a camera's frames to search: that in which the light flashes strongest."""

from __future__ import annotations

from blob_tracker.colour import AUTO, channels, in_channel
from blob_tracker.segmentation.box import Box
from blob_tracker.segmentation.history import FrameError
from blob_tracker.types import Frame
import numpy as np

LEAST_RISE_SIGMA = 7.0  # of the noise of a square of 3 x 3 px: no chance among all of a frame's
BETTER = 1.25  # times the SNR of the channel in use is worth a change
VOTES = 3  # flashes in a row that another channel must be better in, once the first is chosen
LEAST_NOISE_DN = 0.1  # DN, of the mean of a square: rounding alone
SAMPLED = 20_000  # px that tell the noise to 1 %


class ChannelChoice:
    """
    Choose the channel of colour frames.

    The rise of each channel from one frame to the next is averaged over squares of 3 x 3 px; its
    SNR is the highest one over the standard deviation of all. The first flash decides at once.
    Afterwards another channel has to be better by a quarter in three flashes in a row, since a
    change makes the search begin afresh. A light that does not flash does not choose: name its
    colour.

    Parameters
    ----------
    channel : str
        One of `blob_tracker.colour.CHANNELS`, or 'auto'.

    Attributes
    ----------
    name : str
        As it was given.
    channel : str
        The one in use.

    """

    def __init__(self, channel: str = AUTO) -> None:
        self.name = channel
        self._auto = channel == AUTO
        self.channel = 'luma' if self._auto else channel
        self._before: Frame | None = None
        self._chosen = False
        self._votes = 0

    def take(self, frame: Frame, region: Box | None) -> tuple[Frame, Frame | None]:
        """
        Take the next frame as the camera gave it.

        Parameters
        ----------
        frame : Frame
            Grey, or with colours.
        region : Box or None
            Where the target is, px of the grey frames; None if it may be anywhere.

        Returns
        -------
        Frame, Frame or None
            Its channel, and the frame before it in that channel where it is another one from now
            on.

        Raises
        ------
        FrameError
            The frame has no such channel.

        """
        before, self._before = self._before, frame
        if frame.layout == 'grey' and self.channel == 'luma':
            return frame, None  # as most are
        if self._auto and before is not None and channels(frame) and _alike(before, frame):
            best = self._best(before, frame, region)
            if best != self.channel:
                self.channel = best
                self._chosen = True
                return in_channel(frame, best), in_channel(before, best)
        try:
            return in_channel(frame, self.channel), None
        except ValueError as error:
            raise FrameError(str(error)) from None

    def _best(self, before: Frame, frame: Frame, region: Box | None) -> str:
        """Return the channel to use from this frame on."""
        snr = {each: _rise(before, frame, each, region) for each in channels(frame)}
        now = 'green' if self.channel not in snr else self.channel
        best = max(snr, key=lambda each: snr[each])
        if snr[best] < LEAST_RISE_SIGMA:
            return self.channel  # no flash in this frame
        if snr[best] < BETTER * snr[now]:
            self._chosen, self._votes = True, 0
            return self.channel
        self._votes += 1
        if self._chosen and self._votes < VOTES:
            return self.channel
        self._votes = 0
        return best


def _alike(before: Frame, frame: Frame) -> bool:
    """Tell whether two frames can be compared."""
    return (
        (before.layout, before.image.shape, before.image.dtype)
        == (frame.layout, frame.image.shape, frame.image.dtype)
        and before.stamp_ns < frame.stamp_ns
    )


def _rise(before: Frame, frame: Frame, channel: str, region: Box | None) -> float:
    """Return the SNR of the highest rise of a channel in a region."""
    one, other = (in_channel(each, channel).image for each in (before, frame))
    if region is not None:
        one, other = one[region.slices], other[region.slices]
    if not one.size:
        return 0.0
    import cv2  # no part of a start

    rise = cv2.blur(cv2.subtract(other, one, dtype=cv2.CV_32F), (3, 3))
    some = rise.ravel()[::max(rise.size // SAMPLED, 1)]
    level = float(np.median(some))
    noise = 1.4826 * float(np.median(np.abs(some - level)))  # of a Gaussian, by its quartiles
    return (float(rise.max()) - level) / max(noise, LEAST_NOISE_DN)
