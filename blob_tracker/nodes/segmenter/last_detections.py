"""What a segmenter saw last, for its diagnostics: the unlit half of the frames has no light."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.ros.diagnostics.health import Health
from blob_tracker.segmentation import Detections, FieldSegmenter
from blob_tracker.segmentation.candidate import Candidate

PAUSE_NS = 25_000_000  # ns: faster frames are not all looked at, as who reads of them is slower
LEAST_NOISE_DN = 0.01  # pixels that are all equal have none


class LastDetections:
    """
    Remember the last detections, the last candidates, the last target and why there was none.

    Attributes
    ----------
    detections : Detections or None
        The last ones; None before the first.

    """

    def __init__(self) -> None:
        self.detections: Detections | None = None
        self._looked_ns = {True: -PAUSE_NS, False: -PAUSE_NS}  # by whether there is a light
        self._reason = ''
        self._candidates: Sequence[Candidate] = ()
        self._with_target: Sequence[Candidate] = ()

    def reset(self) -> None:
        """Forget what was seen: what follows is of another time."""
        self.detections = None
        self._candidates = self._with_target = ()

    def update(self, segmenter: FieldSegmenter, now_ns: int) -> Detections | None:
        """
        Take the detections that the segmenter has; None if they are the former ones.

        A frame that is only gathered, or begins a new search, leaves them as they were; and so
        does one that follows too soon on another of its kind, with a light or without.
        `now_ns` is monotonic, ns.
        """
        seen = bool(segmenter.in_view)
        if now_ns - self._looked_ns[seen] < PAUSE_NS:
            return None
        detections = segmenter.detections
        if detections is None or detections is self.detections:
            self.detections = detections
            return None
        self._looked_ns[seen] = now_ns
        self.detections = detections
        self._reason = detections.reason or self._reason
        self._candidates = detections.candidates or self._candidates
        if detections.windows:
            self._with_target = detections.candidates
        return detections

    def describe(self, health: Health) -> None:
        """Show it."""
        if self.detections is not None:
            health.show('flash lock', self.detections.state)
            health.show('noise (DN)', f'{self.detections.noise:.2f}')
        if self._reason:
            health.show('last frame without target', self._reason)
        target = next((each for each in self._with_target if not each.rejected), None)
        if target is not None:
            health.show('contrast (DN)', f'{target.amplitude:.1f}')
            health.show(
                'contrast / noise', f'{target.amplitude / max(target.noise, LEAST_NOISE_DN):.1f}'
            )
        if self._candidates:
            first = self._candidates[0]
            health.show('last candidates', len(self._candidates))
            health.show(
                'strongest of them',
                f'SNR {first.snr:.1f} at ({first.x:.0f}, {first.y:.0f}): '
                f'{first.rejected or "may be the target"}',
            )
