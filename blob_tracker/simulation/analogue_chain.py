"""From the light on an analogue camera's cells to the mean signal at the grabber's converter."""

from __future__ import annotations

from dataclasses import dataclass

from blob_tracker.camera.trailing_edge import TrailingEdge
from blob_tracker.simulation.frame_grabber import CELLS, grabbed, PIXELS
from blob_tracker.simulation.line_jitter import (
    displaced_lines, jittering_offsets, line_offsets,
)
from blob_tracker.simulation.profiles import Profile
from blob_tracker.simulation.trailing_edge import peaked
import numpy as np
from numpy.typing import ArrayLike, NDArray

LINES = 480  # of the grabber's picture (thesis, page 11)
AHEAD_PX = 24  # px drawn to the left of a window, so that the camera's memory comes filled


@dataclass(frozen=True)
class AnalogueChain:
    """
    The defects of an analogue camera and its frame grabber; as it stands none of them.

    Parameters
    ----------
    drift : float
        Of the lines of a field, in parts of what thesis Figure 2.4 shows (0.25 px).
    between_fields : float
        Offset of the second field of an interlaced picture, px.
    per_line : float
        Jitter of each line by itself, from frame to frame, rms, px.
    per_frame : float
        Jitter of all lines of a frame together, rms, px.
    trailing_edge : TrailingEdge or None
        The camera's peaking.
    own_clock : bool
        The grabber samples the line in its own time: 641 cells on 640 pixels.

    """

    drift: float = 0.0
    between_fields: float = 0.0
    per_line: float = 0.0
    per_frame: float = 0.0
    trailing_edge: TrailingEdge | None = None
    own_clock: bool = False

    def offsets(self, lines: int = LINES) -> NDArray[np.float64]:
        """Return the mean offset of each of the (lines,) lines of the picture, px."""
        alone = line_offsets(lines, between_fields=0.0)
        second = self.between_fields * (np.arange(lines) % 2)
        return self.drift * alone + second

    def seen_at(self, x: ArrayLike) -> NDArray[np.float64]:
        """
        Return where the grabber's clock puts a point of the cells, px of the picture.

        Parameters
        ----------
        x : float or array
            Place on the cells, px; what the line jitter adds is left out.

        """
        place = np.asarray(x, dtype=float)
        return (place + 0.5) * PIXELS / CELLS - 0.5 if self.own_clock else place

    def window(
        self,
        shape: tuple[int, int],
        corner: tuple[int, int],
        x: float,
        y: float,
        profile: Profile,
        sigma: float,
        amplitude: float,
        background: float,
        random: np.random.Generator,
    ) -> NDArray[np.float64]:
        """
        Draw the mean signal of part of one frame with a blob in it.

        The cells of a line are displaced first (its start comes at another time), then the
        camera's filter works along them, and the grabber samples what it gives.

        Parameters
        ----------
        shape : (int, int)
            Height and width of the window, px.
        corner : (int, int)
            Column and row of its first pixel in the picture.
        x, y : float
            Place of the blob on the cells, px of the whole picture.
        profile : Profile
            Shape of the blob.
        sigma : float
            Its size, px.
        amplitude : float
            Peak above the background, DN.
        background : float
            DN above black.
        random : Generator
            Draws the jitter.

        Returns
        -------
        (h, w) array
            DN; may be below black, where `expose` clips it.

        """
        height, width = shape
        left = max(corner[0] - AHEAD_PX, 0)
        lines = corner[1] + np.arange(height)
        offsets = jittering_offsets(
            self.offsets()[lines], random, per_line=self.per_line, per_frame=self.per_frame
        )
        count = corner[0] - left + width + 2  # the cells of a pixel reach past it
        mean = background + amplitude * profile.over_pixels(
            (height, count), x - left + offsets, y - corner[1], sigma
        )
        if self.trailing_edge is not None:
            mean = peaked(mean, self.trailing_edge)
        if self.own_clock:
            mean = grabbed(mean, first=left, count=count - 2)
        return mean[:, corner[0] - left:][:, :width]

    def field(
        self, mean: NDArray[np.floating], first: int, random: np.random.Generator
    ) -> NDArray[np.float64]:
        """
        Carry the lines of a field, whole, to the grabber's converter; in the order of `window`.

        Parameters
        ----------
        mean : (h, w) array
            Mean signal of the cells, DN above black.
        first : int
            The first of its lines in the picture, of which it has every second one: 0 or 1.
        random : Generator
            Draws the jitter.

        Returns
        -------
        (h, w) array
            DN; what a line begins with counts as what was there before it.

        """
        height, width = mean.shape
        offsets = jittering_offsets(
            self.offsets(2 * height)[first::2], random, per_line=self.per_line,
            per_frame=self.per_frame,
        )
        lines = displaced_lines(mean, offsets) if offsets.any() else np.asarray(mean, float)
        if self.trailing_edge is not None:
            lines = peaked(lines, self.trailing_edge)
        if self.own_clock:
            lines = grabbed(np.pad(lines, ((0, 0), (0, 1)), mode='edge'), first=0, count=width)
        return lines
