"""Lit and unlit windows of lights whose rows, or whose frames, share out the flash."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from blob_tracker.location import Estimates, Locator
from blob_tracker.location.pulse import integrated_profile
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import Location, SensorNoise, Window
import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

NOISE = SensorNoise(gain=10.0, read_noise=1.0)
BACKGROUND = 30.0  # DN
PEAK = 120.0  # DN
SIGMA = 1.5  # px
SIZE = 13  # px, of a window
FRAME = 90  # px, of a frame
FRAME_NS = 16_666_667  # at 60 frames a second
SATURATION = 255


class Pairs(NamedTuple):
    """N pairs of windows with the truth."""

    lit: NDArray[np.generic]
    unlit: NDArray[np.generic]
    x: Floats
    y: Floats

    def nees(self, found: Estimates) -> float:
        """Return the mean normalised squared error of estimates, which are all there."""
        assert found.ok.all()
        errors = np.stack([found.x - self.x, found.y - self.y], axis=1)
        return nees(errors, found.covariance)

    def rms(self, found: Estimates) -> float:
        """Return the rms distance from the truth, px."""
        return float(np.sqrt(np.mean((found.x - self.x) ** 2 + (found.y - self.y) ** 2)))


def nees(errors: ArrayLike, covariances: ArrayLike) -> float:
    """Return the mean normalised squared error; two for a true covariance."""
    errors, covariances = np.asarray(errors), np.asarray(covariances)
    return float(
        np.einsum('ni,nij,nj->n', errors, np.linalg.inv(covariances), errors).mean()
    )


def pulses(size: int, x: ArrayLike, y: ArrayLike) -> Floats:
    """Return (N, size, size) pulses of unit peak."""
    down, across = integrated_profile(size, y, SIGMA)[0], integrated_profile(size, x, SIGMA)[0]
    return np.asarray(down[..., :, None] * across[..., None, :])


def pairs(
    count: int,
    share: Callable[[Floats, Floats], Floats],
    share_unlit: Callable[[Floats, Floats], Floats],
    *,
    shift: tuple[float, float] = (0.0, 0.0),
    lamp: tuple[float, float, float] = (0.0, 0.0, 0.0),
    seed: int = 1,
) -> Pairs:
    """
    Expose pairs whose rows have a share of the flash each.

    Parameters
    ----------
    count : int
        N.
    share, share_unlit : callable
        Rows (SIZE,) and the lights' y (N, 1) -> shares in the two windows.
    shift : (float, float)
        From the light in the lit window to that in the unlit one, px.
    lamp : (float, float, float)
        A light in both windows: its place from the pulse, px, and its peak, DN.
    seed : int
        Of places and noise.

    """
    random = np.random.default_rng(seed)
    x, y = (SIZE - 1) / 2 + random.uniform(-0.5, 0.5, (2, count))
    rows = np.arange(SIZE, dtype=float)
    behind = BACKGROUND + lamp[2] * pulses(SIZE, x + lamp[0], y + lamp[1])
    images = [
        expose(
            behind + PEAK * np.broadcast_to(part(rows, y[:, None]), (count, SIZE))[:, :, None]
            * pulses(SIZE, x + k * shift[0], y + k * shift[1]),
            NOISE, random, saturation=SATURATION,
        )
        for k, part in enumerate((share, share_unlit))
    ]
    return Pairs(images[0], images[1], x, y)


def evenly(share: float) -> Callable[[Floats, Floats], Floats]:
    """Return the same share for every row."""
    return lambda rows, y: np.full(rows.shape, share)


class Flight(NamedTuple):
    """What a `Locator` made of a sequence of frames: where it was right, and what it said."""

    errors: Floats
    locations: list[Location]

    @property
    def nees(self) -> float:
        """Return the mean normalised squared error."""
        return nees(self.errors, [each.covariance for each in self.locations])

    def said(self, words: str) -> float:
        """Return in how many of the locations a warning holds these words."""
        return float(np.mean([words in each.warning for each in self.locations]))


def fly(
    places: Floats,
    share: Callable[[int, Floats], Floats],
    *,
    kept: float = 0.0,
    skip: int = 20,
    seed: int = 1,
) -> Flight:
    """
    Have a Locator follow a light through frames, every other of them lit.

    Parameters
    ----------
    places : (F, 2) array
        Of the light in each frame, px.
    share : callable
        Index of the frame and its rows -> light of each row.
    kept : float
        Of the last frame, by a recursive filter in time.
    skip : int
        Flashes to begin with that are not judged.
    seed : int
        Of the noise.

    """
    random = np.random.default_rng(seed)
    locator = Locator()
    rows = np.arange(FRAME, dtype=float)
    errors, locations = [], []
    state = before = None
    for k, (x, y) in enumerate(places):
        mean = BACKGROUND + PEAK * share(k, rows)[:, None] * pulses(FRAME, x, y)
        noise = np.sqrt(mean / NOISE.gain + NOISE.read_noise**2)
        seen = mean + noise * random.standard_normal(mean.shape)
        state = seen if state is None else kept * state + (1.0 - kept) * seen
        image = np.clip(np.rint(state), 0, SATURATION)
        if before is not None and k % 2 == 0:
            x0, y0 = round(x) - SIZE // 2, round(y) - SIZE // 2
            part = np.s_[y0:y0 + SIZE, x0:x0 + SIZE]
            window = Window(
                image[part], before[part], x0, y0, k * FRAME_NS, saturation=SATURATION
            )
            location = locator.locate(window, noise=NOISE)
            if k >= 2 * skip:
                errors.append((location.x - x, location.y - y))
                locations.append(location)
        before = image
    return Flight(np.array(errors), locations)


def circle(frames: int, speed: float) -> Floats:
    """Return (frames, 2) places of a light that goes round, `speed` px a frame."""
    radius = 25.0
    angle = np.arange(frames) * speed / radius
    return FRAME / 2 + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
