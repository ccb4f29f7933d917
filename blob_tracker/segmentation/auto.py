"""A light of which nothing is known: alternate is tried first, then the light itself is asked."""

from __future__ import annotations

from collections.abc import Sequence

from blob_tracker.blinking.survey import Light
from blob_tracker.blinking.wording import describe
from blob_tracker.segmentation.blink import Blink
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.flash import Flash
from blob_tracker.segmentation.in_step import InStep
from blob_tracker.segmentation.patterns import flash_values, rate_fault
from blob_tracker.segmentation.switching import Switching
from blob_tracker.segmentation.watch import Watch
from blob_tracker.types import Frame
import numpy as np

TRY_S = 1.0  # s that the mode alternate has to find a light; after it did not, twice as long
LONGEST_TRY_S = 16.0
LOST_S = 3.0  # s without a light that was found: as long as a watch
WATCH_S = 3.0  # s: two periods of a code of 64 bits at 60 frames/s take 2.1
MOST_FRAMES = 360  # that are kept of a watch, whatever the frame rate
MOST_LIGHTS = 4  # that are looked at: they take 0.1 to 0.2 s each, once a watch
OFTEN = 0.4  # of the frames: in half of them a light is seen that is on in every other one


class Auto(Switching):
    """
    Find out how the light blinks, then follow it.

    The mode alternate begins, which finds its light in three frames. Where it has none, or one
    that is seen too seldom, for a second, all points are watched for three, and of the lights that
    blink the brightest is followed by its frequency or code. A light that was found and is lost
    for three seconds is looked for in the same order again. While it watches there is no window.

    Parameters
    ----------
    max_pair_interval, registration, gate_px
        Those of `InStep`.
    exposure : float
        Of a frame, s; 0 where the frames tell.

    """

    def __init__(
        self,
        *,
        max_pair_interval: float = 0.0,
        registration: str = 'none',
        gate_px: float = 24.0,
        exposure: float = 0.0,
    ) -> None:
        self._max_pair_interval, self._exposure = max_pair_interval, exposure
        self._registration, self._gate_px = registration, gate_px
        self._why = ''
        self._warning = ''
        self.finding = ''
        self._patience = TRY_S
        super().__init__(self._new_alternate())
        self.reason = self._mode.reason
        self._since_ns: int | None = None  # of the frames and windows that are counted
        self._frames = self._windows = 0
        self._found = False  # by the mode of the time

    @property
    def warning(self) -> str:
        """Say what is wrong though the target may be there; empty if nothing is."""
        return self._mode.warning or self._warning

    @property
    def gate_px(self) -> float:
        """Greatest way of the target from one flash to the next, px."""
        return self._gate_px

    def agree_with(self, place: Expectation | None) -> None:
        """Say where another view follows the target, for the next frame: see `Confirmation`."""
        if isinstance(self._mode, InStep):
            self._mode.agree_with(place)

    def contrast(self, frame: Frame, expected: Expectation | None = None) -> Contrast | None:
        """
        Take the next frame; return what the mode of the time compares.

        Raises
        ------
        FrameError
            If the frame cannot follow those before it.

        """
        self._change(frame.stamp_ns)
        contrast = self._mode.contrast(frame, expected)
        self.reason = self._said()
        return contrast

    def choose(
        self, contrast: Contrast, candidates: Sequence[Candidate]
    ) -> list[tuple[str, Candidate]]:
        """Return the light, under the empty name."""
        self._frames += 1
        chosen = self._mode.choose(contrast, candidates)
        self._windows += bool(chosen)
        self.reason = self._said()
        return chosen

    def _said(self) -> str:
        """Return why there is no light."""
        if isinstance(self._mode, Watch):
            found = self._mode.found
            whole = min(WATCH_S, found.longest)
            return f'watching what blinks: {found.seconds:.1f} s of {whole:.2g}'
        return '; '.join(filter(None, (self._mode.reason, self._why)))

    def _begin(self, flash: Flash, stamp_ns: int) -> None:
        """Go on in this mode."""
        self._mode = flash
        self._found = False
        self._count_anew(stamp_ns)

    def _count_anew(self, stamp_ns: int) -> None:
        self._since_ns = stamp_ns
        self._frames = self._windows = 0

    def _new_alternate(self) -> InStep:
        return InStep(
            max_pair_interval=self._max_pair_interval, registration=self._registration,
            gate_px=self._gate_px, exposure=self._exposure,
        )

    def _change(self, stamp_ns: int) -> None:
        """Go on in another mode before the next frame, where this one has had its time."""
        if self._since_ns is None or stamp_ns < self._since_ns:
            self._count_anew(stamp_ns)
        assert self._since_ns is not None
        seconds = (stamp_ns - self._since_ns) / 1e9
        if isinstance(self._mode, Watch):
            found = self._mode.found
            # Where frames are lost time and again it never has so long a series.
            if found.seconds > WATCH_S or found.full or seconds > 2.0 * WATCH_S:
                self._decide(self._mode, stamp_ns)
        elif isinstance(self._mode, InStep) and not self._found:
            if seconds > self._patience:
                if self._windows and self._windows >= OFTEN * self._frames:
                    self.finding = 'on in every other frame; set flash.mode alternate'
                    self._why = ''
                    self._patience = TRY_S
                    self._found = True
                    self._count_anew(stamp_ns)
                else:
                    self._begin(self._new_watch(), stamp_ns)
        elif seconds > LOST_S:
            if self._windows:
                self._count_anew(stamp_ns)
            else:
                self._warning = ''
                self._begin(self._new_alternate(), stamp_ns)

    def _new_watch(self) -> Watch:
        return Watch(
            max_pair_interval=self._max_pair_interval, exposure=self._exposure, most=MOST_FRAMES
        )

    def _decide(self, watch: Watch, stamp_ns: int) -> None:
        """Go on with the brightest of the lights that blink; with alternate where none does."""
        lights = watch.lights(sigmas=False, most=MOST_LIGHTS)
        usable = [light for light in lights if _is_usable(light)]
        if not usable:
            others = '; '.join(describe(light) for light in lights) or 'nothing blinks'
            self._why = f'watched for {watch.found.seconds:.1f} s: {others}'
            self._patience = min(2.0 * self._patience, LONGEST_TRY_S)
            self._begin(self._new_alternate(), stamp_ns)
            return
        light = max(usable, key=_flux)
        bits = light.rhythm.bits
        values = flash_values({'light' if bits else '': light})
        if bits:
            flash = Blink(
                codes={'': bits}, bits_per_second=float(values['flash.bits_per_second']),
                exposure=self._exposure, max_pair_interval=self._max_pair_interval,
            )
        else:
            flash = Blink(
                frequencies={'': float(values['flash.frequency'])},
                duty=float(values['flash.duty']), exposure=self._exposure,
                max_pair_interval=self._max_pair_interval,
            )
        asked = ', '.join(
            f"{name} '{value}'" if name == 'flash.codes' else f'{name} {value}'
            for name, value in values.items()
        )
        self.finding = f'{describe(light)}; set {asked}'
        self._warning = '' if len(usable) == 1 else (
            f'{len(usable)} lights blink, the brightest is followed: '
            + '; '.join(describe(each) for each in usable)
            + '. Name them in flash.codes or flash.frequencies to have all'
        )
        self._why, self._patience = '', TRY_S
        self._begin(flash, stamp_ns)


def _is_usable(light: Light) -> bool:
    """Tell whether a light can be followed by its pattern; alternate has been tried."""
    if not light.repeats or light.alternates:
        return False
    return bool(light.rhythm.bits) or not rate_fault({'': light.frequency}, light.rate)


def _flux(light: Light) -> float:
    """Return the light of a light where it is full, DN px^2."""
    return float(np.percentile(light.path.flux, 75.0))
