"""A faint light that runs free and stands still: lock-in demodulation over k frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from blob_tracker.segmentation.box import box_about
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.candidates import table_of
from blob_tracker.segmentation.contrast import Contrast
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.frame_stack import most_frames
from blob_tracker.segmentation.history import FrameHistory
from blob_tracker.segmentation.steady import strongest
from blob_tracker.segmentation.whole_frame import WholeFrame
from blob_tracker.types import Frame
import numpy as np
from numpy.typing import NDArray

LEAST_FRAMES = 4  # one more than there are unknowns in a pixel
# Of the frame rate; beyond 0.5 the frequency is aliased
LOWEST_FREQUENCY, HIGHEST_FREQUENCY = 0.1, 0.45
# What the halves of a block may differ by: noise, a part of the light where an edge of it falls
# into an exposure, and px that move the place by no more than its usual error
HALVES_SIGMA, HALVES_PART, HALVES_PX = 4.0, 0.3, 0.25
ELSE = 'the mode periodic follows lights that move'
STAMP_JITTER = 0.01  # of the frame rate, as the stamps tell it
LEAST_NOISE_DN = float(np.sqrt(1 / 12))  # DN, of the rounding of one frame
ZERO_LEVEL = 32767  # of the demodulated picture where nothing flashes; full scale is twice that


class LockIn(WholeFrame):
    """
    Demodulate each pixel at the light's frequency f over blocks of k frames.

    Per pixel the least-squares fit to the stamps t_i,

        I_i = m + a cos(2 pi f t_i) + b sin(2 pi f t_i),

    gives the amplitude sqrt(a^2 + b^2) in any phase of the light. The variance of a and of b is
    2/k of a pixel's, so that the SNR grows with sqrt(k). Of a light that is on for the part d of
    its period, exposed for the time T, the fundamental is (2 / pi) sin(pi d) sinc(f T) of its
    height: an exposure that straddles the edge costs no more than that sinc.

    The light must stand still within a block, to a fraction of its width. Each half of the block
    is demodulated by itself, too: where the two do not agree on its place or its brightness it
    moved, and there is no window. Its phase in the block, once found, says which of the frames are
    the most and the least lit: these make the window.

    Parameters
    ----------
    max_pair_interval : float
        Greatest time from one frame to the next, s; a longer gap begins a new block; 0 as
        `FrameHistory` has it.
    frequency : float
        f, Hz; from 0.1 to 0.45 of the frame rate.
    duty : float
        d, above 0 and below 1.
    frames : int
        k.

    """

    locked = False
    warning = ''
    finding = ''

    def __init__(
        self,
        *,
        max_pair_interval: float = 0.0,
        frequency: float = 15.0,
        duty: float = 0.5,
        frames: int = 16,
    ) -> None:
        if frames < LEAST_FRAMES:
            raise ValueError(f'a block of {frames} frames; it must have {LEAST_FRAMES} or more')
        if not (frequency > 0.0 and 0.0 < duty < 1.0):
            raise ValueError(
                f'frequency {frequency} Hz and duty {duty}; they must be above 0, the duty below 1'
            )
        self.frequency = frequency
        self.duty = duty
        self.frames = frames
        self.reason = 'no frame yet'
        self._history = FrameHistory(frames, max_pair_interval)
        self._new_frames = 0
        self._halves: list[NDArray[np.float32]] = []  # of a block, in the light's phase

    def contrast(self, frame: Frame, expected: Expectation | None = None) -> Contrast | None:
        """
        Take the next frame; the last one of a block shows whether the light is there.

        Raises
        ------
        FrameError
            If the frame cannot follow the one before it.

        """
        block = self._history.frames
        self._history.push(frame)
        self._new_frames = min(self._new_frames + 1, len(block))
        if self._new_frames < self.frames:
            self.reason = (
                f'frame {self._new_frames} of the {self.frames} that are demodulated together'
            )
            return None
        self._new_frames = 0
        self.reason = ''
        return self._demodulate(list(block))

    def choose(
        self, contrast: Contrast, candidates: Sequence[Candidate]
    ) -> list[tuple[str, Candidate]]:
        """Return the candidate of the highest SNR, under the empty name."""
        index = strongest(table_of(candidates), -np.inf)
        if index < 0:
            return []
        light = candidates[index]
        self.reason = self._moved(light)
        return [] if self.reason else [('', light)]

    def _moved(self, light: Candidate) -> str:
        """Say how the halves of the block differ on a light; empty if noise may do so."""
        if len(self._halves) < 2:
            return ''
        x, y = light.x, light.y
        half = int(np.ceil(2.0 * light.sigma_major)) + 1
        column, row = round(x), round(y)
        shape = self._halves[0].shape
        box = box_about(column, row, half, half, (shape[0], shape[1]))
        down, across = np.mgrid[box.slices]
        bell = np.exp(
            -0.5 * ((across - x) ** 2 + (down - y) ** 2) / max(light.sigma_major, 1.0) ** 2
        )
        total = float((bell**2).sum())
        heights, places = [], []
        for picture in self._halves:
            part = picture[box.slices] * bell
            heights.append(float(part.sum()) / total)
            light_of_half = max(float(part.sum()), 1e-9)
            # The bell draws the centroid half-way to itself.
            places.append(2.0 * np.array([
                (part * (across - x)).sum(), (part * (down - y)).sum()
            ]) / light_of_half)
        # Each half has half of the frames: its noise is the root of two times the block's.
        noise = np.sqrt(2.0) * light.noise
        height_sigma = np.sqrt(2.0) * noise / np.sqrt(total)
        mean = 0.5 * (heights[0] + heights[1])
        if abs(heights[0] - heights[1]) > HALVES_SIGMA * height_sigma + HALVES_PART * abs(mean):
            return (
                f'the halves of the block show {heights[0]:.1f} and {heights[1]:.1f} DN: the '
                f'light moved or came and went; {ELSE}'
            )
        shift = float(np.hypot(*(places[0] - places[1])))
        shift_sigma = height_sigma / max(mean, 1e-9) * light.sigma_major * np.sqrt(2.0)
        if shift > HALVES_SIGMA * shift_sigma + HALVES_PX:
            return (
                f'the light moved by {shift:.1f} px from one half of the block to the other; '
                + ELSE
            )
        return ''

    def _demodulate(self, block: list[Frame]) -> Contrast | None:
        """Return the light of a block, or None."""
        import cv2  # no part of a start

        times = np.array([each.stamp_ns - block[0].stamp_ns for each in block]) / 1e9
        rate = 1.0 / float(np.median(np.diff(times)))  # a dropped frame leaves it as it is
        least = (1 - STAMP_JITTER) * LOWEST_FREQUENCY * rate
        if not least <= self.frequency <= (1 + STAMP_JITTER) * HIGHEST_FREQUENCY * rate:
            self.reason = (
                f'the light is said to flash at {self.frequency:g} Hz; {rate:.1f} frames a second '
                f'show {LOWEST_FREQUENCY * rate:.1f} to {HIGHEST_FREQUENCY * rate:.1f} Hz'
            )
            return None
        phases = 2.0 * np.pi * self.frequency * times
        weights = lock_in_weights(phases)
        in_phase, quadrature = demodulate([each.image for each in block], weights)
        _, height, _, (column, row) = cv2.minMaxLoc(cv2.magnitude(in_phase, quadrature))
        if height == 0.0:
            self.reason = 'nothing changes from frame to frame'
            return None
        cosine, sine = in_phase[row, column] / height, quadrature[row, column] / height
        # Seen in the light's own phase the noise is Gaussian, and what flashes otherwise is less.
        own = cv2.addWeighted(in_phase, float(cosine), quadrature, float(sine), 0.0)
        self._halves = []
        middle = len(block) // 2
        for half in (slice(0, middle), slice(middle, None)):
            if len(block[half]) >= LEAST_FRAMES:
                one, other = demodulate(
                    [each.image for each in block[half]], lock_in_weights(phases[half])
                )
                self._halves.append(np.asarray(
                    cv2.addWeighted(one, float(cosine), other, float(sine), 0.0), np.float32
                ))
        brightness = cosine * np.cos(phases) + sine * np.sin(phases)
        order = np.argsort(brightness, kind='stable')
        # The fewer of lit and unlit frames, but for those that an edge may run through.
        part = min(self.duty, 1.0 - self.duty)
        last = block[-1]
        count = max(min(int(part * len(block) - 0.5), most_frames(last.sample_saturation)), 1)
        # In the middle of the frames that are lit, as the sum of their exposures is.
        lit = [block[index] for index in sorted(order[-count:])]
        unlit = [block[index] for index in sorted(order[:count])]
        instant = sum(each.stamp_ns - lit[0].stamp_ns for each in lit) // count + lit[0].stamp_ns
        # Whole steps of a part of a DN: what the search takes, and finer than the noise.
        unit = last.saturation / ZERO_LEVEL
        picture = cv2.addWeighted(own, 1.0 / unit, own, 0.0, ZERO_LEVEL, dtype=cv2.CV_16U)
        return Contrast(
            np.asarray(picture),
            np.full(own.shape, ZERO_LEVEL, np.uint16),
            2 * ZERO_LEVEL,
            replace(last, stamp_ns=instant),
            tuple(each.samples for each in lit),
            tuple(each.samples for each in unlit),
            LEAST_NOISE_DN * float(np.sqrt((weights[0] ** 2).sum())) / unit,
            unit,
            float(times[-1]),
        )


def lock_in_weights(phases: NDArray[np.float64]) -> NDArray[np.float64]:
    """
    Return the (2, k) weights that take k frames to the cosine and sine parts of their change.

    They are the rows of the pseudo-inverse of [1, cos, sin]: the least-squares solution whatever
    the phases, also where the block holds no whole number of periods or a frame was dropped.
    """
    design = np.column_stack([np.ones_like(phases), np.cos(phases), np.sin(phases)])
    return np.asarray(np.linalg.pinv(design)[1:])


def demodulate(
    images: list[NDArray[np.generic]], weights: NDArray[np.float64]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the two (h, w) weighted sums of the frames, DN."""
    import cv2

    sums = [np.zeros(images[0].shape, np.float32) for _ in weights]
    for image, column in zip(images, weights.T):
        pixels = image.astype(np.float32)
        for total, weight in zip(sums, column):
            cv2.scaleAdd(pixels, float(weight), total, dst=total)
    return sums[0], sums[1]
