"""Lights that blink codes or waves, at any phase and in motion: each followed in every frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import functools
import math

from blob_tracker.blinking import BlinkTracker, code, Known, Lit, Pattern, wave
from blob_tracker.blinking.paths import PathLinker
from blob_tracker.blinking.tracker import MOST_POINTS
from blob_tracker.kernel import Array
from blob_tracker.segmentation.box import box_about, whole
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.dark_look import DarkLook, FEWEST
from blob_tracker.segmentation.flash_watch import UNKNOWN_EXPOSURE
from blob_tracker.segmentation.patterns import check_patterns, rate_fault, twin_fault
from blob_tracker.segmentation.points import aperture_sum, LEAST_PEAK_SIGMA
from blob_tracker.segmentation.single_frames import seen_points, SingleFrames
from blob_tracker.types import Frame, Glimpse
import numpy as np

WAY_FRACTION = 0.03  # of a streak's length, by which it may be off: its path bends
ABOUT = 4.0  # sigma to each side: a window and its background
# Of what the lines of a rolling shutter draw a light by, as the pulse is no Gaussian
DRAWN_FRACTION = 0.2
LEAST_DARK = 0.02  # of the exposure: what is shorter is not told from none
PULSE_LINES = np.linspace(-3.0, 3.0, 25)  # sigma from the middle of a pulse
PULSE = np.exp(-0.5 * PULSE_LINES**2)
BESIDE = 4.0  # sigma of a light, within which another one draws its place
CROWDED = (
    f'more than {MOST_POINTS} points stand out of the frame, and no light out of them: expose '
    'less, put a filter before the lens, or name with mask_url where the lights may be'
)


class Blink(SingleFrames):
    """
    Follow lights that blink, each in its pattern, and give each lit frame's window its instant.

    What stands out of each frame by itself is a point; `BlinkTracker` tells which of them is
    which light, and when within the exposure it was seen.

    Parameters
    ----------
    max_pair_interval : float
        Greatest time from one frame to the next, s; a longer gap forgets all lights; 0 as
        `FrameHistory` has it.
    codes : mapping of str to str
        Bits of each light by its name: '1101000'.
    frequencies : mapping of str to float
        Hz, of each light that is on for `duty` of its period.
    frames_per_bit : int
        Frames in which a bit is held, where `bits_per_second` is 0.
    bits_per_second : float
        By the lights' own clock, which may be off by 1 %.
    duty : float
        Part of its period for which a light with a frequency is on.
    exposure : float
        Of a frame, s; 0 where the frames tell.

    Raises
    ------
    ValueError
        If a pattern is not one, or two of them are too alike to be told apart.

    """

    def __init__(
        self,
        *,
        codes: Mapping[str, str] | None = None,
        frequencies: Mapping[str, float] | None = None,
        max_pair_interval: float = 0.0,
        frames_per_bit: int = 1,
        bits_per_second: float = 0.0,
        duty: float = 0.5,
        exposure: float = 0.0,
    ) -> None:
        super().__init__(max_pair_interval)
        self._codes, self._frequencies = dict(codes or {}), dict(frequencies or {})
        check_patterns(self._codes, self._frequencies, duty)
        self._frames_per_bit, self._bits_per_second = frames_per_bit, bits_per_second
        self._duty, self._exposure = duty, exposure
        self._tracker: BlinkTracker | None = None
        # Of the frame before there is one
        self._first: tuple[Array, int, float, float] | None = None
        self._assumed = ''  # what is, of the exposure
        self._named = False
        compile_blinking()

    @property
    def locked(self) -> bool:
        """Whether any light was named in the last frame."""
        return self._named

    def _begin(self) -> None:
        super()._begin()
        self._tracker = self._first = None

    def _follow(self, frame: Frame, interval: float) -> str:
        if self._tracker is None:
            fault = self._fault(interval)
            if fault:
                return fault
            self._tracker = self._new_tracker(frame, interval)
        return ''

    def choose(
        self, contrast: Contrast, candidates: Sequence[Candidate]
    ) -> list[tuple[str, Candidate]]:
        """Return the lights that the frame shows, each by its name and with its instant."""
        allowed, table, least = seen_points(contrast, candidates)
        seen = table, contrast.frame.stamp_ns, least, contrast.frame.line_time_ns / 1e9
        if self._tracker is None:
            # The next frame tells the interval.
            self._first, self._named = seen, False
            self.reason = 'waiting for a second frame'
            return []
        if self._first is not None:
            self._tracker.update(*self._first)
            self._first = None
        found = self._tracker.update(*seen)
        self._named = bool(found)
        self.reason = ''
        if not found:
            self.reason = CROWDED if self._tracker.crowded else _why_none(candidates, allowed)
        exposure, known = self._tracker.exposure, self._tracker.known()
        ratio = self._tracker.exposure_ratio
        self.warning = self._assumed if ratio == 1.0 else (
            f'the lights are partly lit as often as an exposure of {1e3 * ratio * exposure:.1f} '
            f'ms would see them, and {1e3 * exposure:.1f} ms are assumed: set flash.exposure; if '
            'it is right they fade, or are switched in step with the frames, within the exposure'
        )
        return [
            (each.name, self._with_dark_look(
                contrast,
                _at_its_instant(
                    allowed[each.point], each, exposure, contrast.frame.line_time_ns / 1e9, known,
                    WAY_FRACTION + abs(ratio - 1.0),
                ),
            ))
            for each in found
        ]

    def _with_dark_look(self, contrast: Contrast, candidate: Candidate) -> Candidate:
        """Return the candidate with a frame in which it was dark, if that tells of the scene."""
        if contrast.unlit is not self._dark.envelope:
            return candidate
        half_x, half_y = (
            math.ceil(ABOUT * sigma) for sigma in (candidate.sigma_x, candidate.sigma_y)
        )
        box = box_about(
            round(candidate.x), round(candidate.y), half_x, half_y, contrast.shape
        )
        return candidate._replace(
            unlit=self._dark.of(box, candidate.noise)
        )

    def _fault(self, interval: float) -> str:
        """Say which light frames of this interval, s, cannot tell; empty if there is none."""
        return rate_fault(self._frequencies, 1.0 / interval) or twin_fault(
            self._codes, self._bit_rate(interval), self._frequencies, self._duty
        )

    def _bit_rate(self, interval: float) -> float:
        return self._bits_per_second or 1.0 / (interval * self._frames_per_bit)

    def _new_tracker(self, frame: Frame, interval: float) -> BlinkTracker:
        exposure = self._exposure or frame.exposure_ns / 1e9
        self._assumed = self.warning = '' if exposure else (
            'nothing says how long a frame is exposed: half of the frame interval is assumed; set '
            'flash.exposure'
        )
        rate = self._bit_rate(interval)
        in_step = 0 if self._bits_per_second else self._frames_per_bit
        patterns: list[Pattern] = [
            code(name, bits, rate, in_step) for name, bits in self._codes.items()
        ]
        patterns += [
            wave(name, frequency, self._duty) for name, frequency in self._frequencies.items()
        ]
        height, width = frame.image.shape[:2]
        return BlinkTracker(
            patterns, interval=interval, exposure=exposure or UNKNOWN_EXPOSURE * interval,
            shape=(height, width),
        )


def _why_none(candidates: Sequence[Candidate], allowed: Sequence[Candidate]) -> str:
    """Say why none of the candidates is a light; empty if the first one itself tells."""
    if allowed:
        return (
            f'of {len(allowed)} in sight none is due and of a known pattern (`calibrate flash` '
            'finds theirs)'
        )
    low = [each for each in candidates if not each.rejected]
    if not low:
        return ''
    return (
        f'the best blob stands {low[0].amplitude:.0f} DN above the scene, '
        f'{low[0].amplitude / low[0].noise:.1f} times its noise and texture; it must be '
        f'{LEAST_PEAK_SIGMA:g} times as high as they are'
    )


def _at_its_instant(
    candidate: Candidate, light: Lit, exposure: float, line_time: float, known: Sequence[Known],
    way_fraction: float,
) -> Candidate:
    """
    Return the candidate with the time at which it was seen, and what is known of its path.

    Over the time T for which it is lit the middle of its light is off its place by a T^2 / 24.
    What another light beside it draws it to is in the doubt: d f' / (f + f'). Its streak may be
    off by `way_fraction` of its length.
    """
    lit = light.share * exposure
    drawn, drawn_sigma = _drawn(light, candidate.sigma_y, exposure, line_time)
    spread = light.covariance.diagonal().tolist()
    speed = math.hypot(light.vx, light.vy)
    sigma = lit * math.sqrt(0.5 * (spread[2] + spread[3]))
    bend, late = lit**2 / 24.0, light.tau_sigma**2
    xx, xy, _, yy = light.bend.ravel().tolist()
    xx += light.vx**2 * late + bend**2 * spread[4]
    xy += light.vx * light.vy * late + bend**2 * float(light.covariance[4, 5])
    yy += light.vy**2 * late + bend**2 * spread[5] + drawn_sigma**2
    reach = BESIDE * candidate.sigma_major + 0.5 * lit * speed
    name, x, y = light.name, candidate.x, candidate.y
    own = max(flux for other, _, _, _, flux in known if other == name)
    for other, other_x, other_y, variance, flux in known:
        dx, dy = other_x - x, other_y - y
        if other != name and math.hypot(dx, dy) < reach + math.sqrt(variance):
            part = (flux / max(flux + own, 1e-9)) ** 2
            xx += part * (dx * dx + variance)
            xy += part * dx * dy
            yy += part * (dy * dy + variance)
    glimpse = Glimpse(
        light.share, np.array([lit * light.vx, lit * light.vy]),
        sigma + way_fraction * lit * speed, np.array([[xx, xy], [xy, yy]]),
        np.array([bend * light.ax, bend * light.ay]), drawn,
    )
    return candidate._replace(tau=light.tau, glimpse=glimpse)


def _drawn(
    light: Lit, sigma: float, exposure: float, line_time: float
) -> tuple[float, float]:
    """
    Return by how much lower a light seems to lie that is switched while its lines are exposed, px.

    And the standard deviation of that: the sign may be in doubt.

    A rolling shutter sees it longer by the line time from line to line after it was switched on
    within the exposure, shorter after it was switched off. Its pulse is weighed by the share
    s + r line_time / E in the line r from the middle, 0 to 1: for a weak slope it is drawn by
    sigma^2 line_time / (s E). Where it was switched tau = +- (1 - s) E / 2, which tells the sign;
    at tau = 0 it was on in the middle of the exposure, for the same time in all lines.
    """
    if not line_time:
        return 0.0, 0.0
    half_dark = max(0.5 * (1.0 - light.share), LEAST_DARK) * exposure
    most = most_drawn(light.share, sigma, exposure, line_time)
    switched = min(max(light.tau / half_dark, -1.0), 1.0)
    unsure = min(light.tau_sigma / half_dark, 1.0)
    return switched * most, math.hypot(unsure, DRAWN_FRACTION) * most


def most_drawn(share: float, sigma: float, exposure: float, line_time: float) -> float:
    """Return by how much lower a light of a sigma seems to lie, px, that was switched on late."""
    rows = sigma * PULSE_LINES
    weights = np.clip(share + line_time / exposure * rows, 0.0, 1.0) * PULSE
    return float((weights * rows).sum() / max(weights.sum(), LEAST_DARK))


@functools.cache
def compile_blinking() -> None:
    """Compile the loops, or load them from Numba's cache, before the first frame needs them."""
    tracker = BlinkTracker(
        [code('a', '110', 60.0)], interval=1 / 60, exposure=1 / 120, shape=(480, 640)
    )
    for index in range(20):
        on = index % 3 != 2
        point = np.array([[100.0, 100.0, 0.01, 0.0, 0.01, 1000.0, 5.0]] * on).reshape(-1, 7)
        tracker.update(point, index * 16_666_667, 50.0)
    PathLinker(1 / 60).update(point, 1.0)  # of what is not known yet, see `Auto`
    for kind in (np.uint8, np.uint16):
        frame = Frame(np.zeros((16, 16), kind), 0, 255)
        look = DarkLook()
        for _ in range(FEWEST + 1):
            look.push(frame)
        look.of(whole((16, 16)), 1.0)
        aperture_sum(frame.image, look.below(frame), 8.0, 8.0, 1.0, 1.0, 0.0, 0.0)


class Coded(Blink):
    """Lights with codes, and such with frequencies beside them: see `Blink`."""


class Periodic(Blink):
    """
    A light with a frequency, which needs no name, or several that have one: see `Blink`.

    Parameters
    ----------
    frequency : float
        Of the light without a name, if there is no other, Hz.
    frequencies, duty, exposure, max_pair_interval
        Those of `Blink`.

    """

    def __init__(
        self,
        *,
        frequencies: Mapping[str, float] | None = None,
        frequency: float = 15.0,
        max_pair_interval: float = 0.0,
        duty: float = 0.5,
        exposure: float = 0.0,
    ) -> None:
        super().__init__(
            frequencies=frequencies or {'': frequency}, max_pair_interval=max_pair_interval,
            duty=duty, exposure=exposure,
        )


class HalfRate(Blink):
    """
    A light that is on in every other frame by a clock of its own, and known to be there.

    Nobody need tell its frequency: the tracker's clocks may be off by 1 %. A lamp that is always
    on looks the same to a camera while the light is half in one frame and half in the next, so
    this is no mode to look for a light with.

    Parameters
    ----------
    interval : float
        Time from frame to frame, s, as good as many stamps tell it.
    slower : float
        Part by which the light's clock is behind the camera's, where that is known.
    max_pair_interval, exposure : float
        Those of `Blink`, s.

    """

    def __init__(
        self, *, interval: float, slower: float = 0.0, max_pair_interval: float = 0.0,
        exposure: float = 0.0,
    ) -> None:
        super().__init__(
            frequencies={'': 0.5 * (1.0 - slower) / interval},
            max_pair_interval=max_pair_interval, exposure=exposure,
        )
        self._interval = interval

    def _follow(self, frame: Frame, interval: float) -> str:
        if self._tracker is None:
            self._tracker = self._new_tracker(frame, self._interval)
        return ''
