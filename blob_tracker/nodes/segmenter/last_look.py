"""What a segmenter saw last, for its diagnostics: the unlit half of the frames has no light."""

from __future__ import annotations

from blob_tracker.ros.diagnostics.health import Health
from blob_tracker.segmentation import Look
from blob_tracker.segmentation.candidate import Candidate

LEAST_NOISE = 0.01  # DN: pixels that are all equal have none


class LastLook:
    """
    Remember the last look, the last candidates, the last target and why there was none.

    Attributes
    ----------
    look : Look or None
        The last one; None before the first.

    """

    def __init__(self) -> None:
        self.look: Look | None = None
        self._reason = ''
        self._candidates: tuple[Candidate, ...] = ()
        self._target: Candidate | None = None

    def reset(self) -> None:
        """Forget what was seen: what follows is of another time."""
        self.look = self._target = None
        self._candidates = ()

    def update(self, look: Look | None) -> Look | None:
        """
        Take what the segmenter has as its look; None where that is the former one.

        A frame that is only gathered, or begins a new search, leaves it as it was.
        """
        if look is None or look is self.look:
            self.look = look
            return None
        self.look = look
        self._reason = look.reason or self._reason
        self._candidates = look.candidates or self._candidates
        if look.windows:
            self._target = next((each for each in look.candidates if not each.refused), None)
        return look

    def describe(self, health: Health) -> None:
        """Show it."""
        if self.look is not None:
            health.show('flash lock', self.look.state)
            health.show('noise (DN)', f'{self.look.noise:.2f}')
        if self._reason:
            health.show('last frame without target', self._reason)
        target = self._target
        if target is not None:
            health.show('contrast (DN)', f'{target.amplitude:.1f}')
            health.show(
                'contrast / noise', f'{target.amplitude / max(target.noise, LEAST_NOISE):.1f}'
            )
        if self._candidates:
            first = self._candidates[0]
            health.show('last candidates', len(self._candidates))
            health.show(
                'strongest of them',
                f'SNR {first.snr:.1f} at ({first.x:.0f}, {first.y:.0f}): '
                f'{first.refused or "may be the target"}',
            )
