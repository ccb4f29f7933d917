"""No flash: the light is on in every frame, and thresholds alone must find it."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.kernel import Array, kernel
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.candidates import table_of
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.history import FrameHistory
from blob_tracker.segmentation.rejection import AMPLITUDE, FIELDS, NOISE, NOTHING, SNR
from blob_tracker.segmentation.whole_frame import WholeFrame
from blob_tracker.types import Frame, Pixels
import numpy as np

ROUNDING_DN = float(np.sqrt(1 / 12))  # DN, of one frame
# Standard deviations of a pixel, the scene's texture among them. A texture is not white: a wide
# filter sums it up as it does the light, so that its SNR alone does not tell them apart.
LEAST_HEIGHT_SIGMA = 5.0


class Steady(WholeFrame):
    """
    Take the blob of each frame that stands out most.

    It must stand above the frame's level by more than the scene does, texture included: with
    nothing to subtract, all that the scene shows is noise.

    Parameters
    ----------
    max_pair_interval : float
        How far the stamps may jump back before the frame counts as a fresh start, s; 0 as
        `FrameHistory` has it.

    """

    locked = False
    warning = ''
    finding = ''

    def __init__(self, *, max_pair_interval: float = 0.0) -> None:
        self.reason = 'no frame yet'
        self._history = FrameHistory(1, max_pair_interval)
        self._nothing: Pixels = np.empty((0, 0), np.uint8)

    def contrast(self, frame: Frame, expected: Expectation | None = None) -> Contrast:
        """
        Return the next frame, and nothing to subtract from it.

        Raises
        ------
        FrameError
            If the frame cannot follow the one before it.

        """
        self._history.push(frame)
        self.reason = ''
        kept = self._history.frames[-1]
        image = kept.image
        if self._nothing.shape != image.shape or self._nothing.dtype != image.dtype:
            self._nothing = np.zeros_like(image)
        return Contrast(
            image, self._nothing, frame.saturation, frame, (kept.samples,), (), ROUNDING_DN
        )

    def choose(
        self, contrast: Contrast, candidates: Sequence[Candidate]
    ) -> list[tuple[str, Candidate]]:
        """Return the candidate of the highest SNR that the scene does not explain."""
        index = strongest(table_of(candidates), LEAST_HEIGHT_SIGMA)
        if index < 0:
            self.reason = self._why_none(candidates)
            return []
        return [('', candidates[index])]

    def _why_none(self, candidates: Sequence[Candidate]) -> str:
        """Return why none of the candidates is taken; '' if all of them are rejected anyway."""
        index = strongest(table_of(candidates), -np.inf)
        if index < 0:
            return ''
        light = candidates[index]
        return (
            f'the best blob stands {light.amplitude:.0f} DN above the scene, '
            f'{light.amplitude / light.noise:.1f} times its noise and texture; a light that '
            f'does not flash must be {LEAST_HEIGHT_SIGMA:g} times as high as they are'
        )


def above_the_scene(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return what is not rejected and too high to be noise or texture."""
    return [
        each for each in candidates
        if not each.rejected and each.amplitude >= LEAST_HEIGHT_SIGMA * each.noise
    ]


@kernel
def strongest(table: Array, least_height: float) -> int:
    """
    Return the row of the highest SNR that is not rejected; -1 if there is none.

    Parameters
    ----------
    table : (n, 23) array
        See `measure_peaks`.
    least_height : float
        Least amplitude, in standard deviations of the noise: below it is noise, or texture.

    """
    best = -1
    for k in range(table.shape[0]):
        if (
            table[k, FIELDS] == NOTHING and table[k, AMPLITUDE] >= least_height * table[k, NOISE]
            and (best < 0 or table[k, SNR] > table[best, SNR])
        ):
            best = k
    return best
