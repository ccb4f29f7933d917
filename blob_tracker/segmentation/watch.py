"""Look on for a while at what blinks in the frames, and how; follow nothing."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from blob_tracker.blinking.survey import Light, MOST_LIGHTS, Survey
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.single_frames import seen_points, SingleFrames
from blob_tracker.types import Frame
import numpy as np

MOST_FRAMES = 3600  # that are kept: a minute at 60 Hz


class Watch(SingleFrames):
    """
    Keep the points of the last frames, to tell which of them are lights that blink.

    Parameters
    ----------
    max_pair_interval : float
        Greatest time from one frame to the next, s; a longer gap forgets all frames; 0 as
        `FrameHistory` has it.
    exposure : float
        Of a frame, s; 0 where the frames tell, or nobody.
    most : int
        Frames that are kept, the last ones.

    """

    locked = False

    def __init__(
        self, *, max_pair_interval: float = 0.0, exposure: float = 0.0, most: int = MOST_FRAMES
    ) -> None:
        super().__init__(max_pair_interval)
        self._exposure, self._most = exposure, most
        self._begin()

    def _begin(self) -> None:
        super()._begin()
        self.found = Survey(self._most)
        self._peaks: deque[Sequence[tuple[float, float]]] = deque(maxlen=self._most)

    def _follow(self, frame: Frame, interval: float) -> str:
        self._exposure = self._exposure or frame.exposure_ns / 1e9
        return ''

    def choose(
        self, contrast: Contrast, candidates: Sequence[Candidate]
    ) -> list[tuple[str, Candidate]]:
        """Keep what stands out; return nothing."""
        allowed, table, least = seen_points(contrast, candidates)
        kept = self.found.push(table, contrast.frame.stamp_ns, least)
        self._peaks.append([(allowed[each].amplitude, allowed[each].snr) for each in kept])
        self.reason = f'watched for {self.found.seconds:.1f} s'
        return []

    def lights(self, *, sigmas: bool = True, most: int = MOST_LIGHTS) -> list[Light]:
        """Return what blinks, see `Survey.lights`."""
        return self.found.lights(self._exposure, sigmas=sigmas, most=most)

    def peak(self, light: Light) -> tuple[float, float]:
        """Return height, DN, and SNR of a light, the medians of its brighter half."""
        own = light.path
        peaks = np.array([
            self._peaks[frame][point] for frame, point in zip(own.frames, own.points)
        ])
        high = peaks[peaks[:, 0] >= np.median(peaks[:, 0])]
        return float(np.median(high[:, 0])), float(np.median(high[:, 1]))
