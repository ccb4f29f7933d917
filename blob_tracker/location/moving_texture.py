"""A texture behind the light that is not the same in the lit frame and in the unlit one."""

from __future__ import annotations

from dataclasses import replace
import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.noise import noise_of_sum, variance_at
from blob_tracker.location.relit import FEWEST_PX, STRONG
from blob_tracker.location.unlit_texture import residual_variance, SHRINKAGE
from blob_tracker.location.unlit_window import ComparedWindows, shared, UnlitWindow
from blob_tracker.types import Location, SensorNoise, Window
import numpy as np

MEMORY = 128.0  # windows that were looked at, after which one weighs 1/e
FEWEST_WINDOWS = 16  # before anything is said
ENOUGH_WINDOWS, EVERY = 128, 16  # beyond so many windows only every sixteenth is looked at
REACH = 3.0  # sigma about the light, that are left out of it
ALWAYS = 0.1  # of the mean square of its height: the square of the mean, of a light that is there
SIGMAS = 3.0  # standard deviations, beyond which there is a texture
MOVING_SIGMAS = 3.0  # beyond which it moves; what chance makes of it grows little
FOLLOWED_SIGMAS = 4.0  # beyond which it surely does, by the unlit frames of two flashes
AT_SLOPES = 4.0 / 9.0  # of a pulse's height, where its slopes are, which tell its place
# Of the variance: what grows it less is not spoken of, if it surely moves and if it may be chance.
LEAST_GROWTH, LEAST_UNSURE_GROWTH = 1.15, 1.3


class MovingTexture:
    """
    Measure how much of the texture behind a light the unlit frame knows.

    The fit takes a share s of the unlit texture off the lit pixels. With u^2 the mean square of
    what an unlit window lends to the place of a pulse, over that of the noise, and 1 + r its mean,
    s = 1 - SHRINKAGE / u^2 (`texture_share`). If the two frames have the correlation rho, as
    camera or background move in between, the variance of the place is, over that noise,

        V = q + r + <s^2 u^2> - 2 rho r / (1 + r) <s u^2>,

    q that of the lit pixels' own noise about the pulse. The fit has q + <a> in its covariance, a
    the `residual_variance` of the share, which V / (q + <a>) lets grow. rho is that of the pixels
    about the light. That it is not 1 is told by these, or sooner by the unlit frames of two
    flashes, between which there is twice the time.

    Attributes
    ----------
    growth : float
        Of the covariance; 1 if there is no such texture, or not known yet.

    """

    def __init__(self) -> None:
        self.growth = 1.0
        self._windows = 0
        # Of the windows that were looked at, weighted: count; height of a pulse in the unlit
        # pixels, and its square, DN; q, u^2, s u^2, s^2 u^2 and a of the class; lit times unlit;
        # unlit squared less noise; its variance; and the last three of the unlit windows of two
        # flashes.
        self._sums = np.zeros(14)
        self._compared = ComparedWindows(EVERY)

    @property
    def warning(self) -> str:
        """Say that the background moves; '' where it does not."""
        if self.growth == 1.0:
            return ''
        return (
            'the texture behind the light moves between the lit and the unlit frame, and its '
            f'position is {math.sqrt(self.growth):.1f} times as uncertain: hold the camera still, '
            'set registration, or raise the frame rate'
        )

    def add(self, window: Window, location: Location, noise: SensorNoise) -> None:
        """
        Take the next window.

        Parameters
        ----------
        window : Window
            Lit and unlit pixels, DN.
        location : Location
            Of its light.
        noise : SensorNoise
            Of a pixel of one frame.

        """
        self._windows += 1
        if window.unlit is None or window.added_noise > 0.0:
            return
        compared = self._compared.take(
            window, location, self._windows, rests=self._windows > ENOUGH_WINDOWS)
        if compared is None:
            return
        middle = window.to_window(location.x, location.y)
        noise = noise_of_sum(noise, window.looks)
        unlit = np.ascontiguousarray(window.unlit, dtype=float)
        limit = math.inf if window.saturation is None else float(window.saturation)
        level, total, height, lent, count, product, lit_square, square = _told(
            np.ascontiguousarray(window.lit, dtype=float), unlit,
            limit, middle, location.sigma,
        )
        if count < FEWEST_PX:
            return
        variance = variance_at(level, noise)
        product = _as_bright(product, lit_square, square, count * variance)
        self._sums *= 1.0 - 1.0 / MEMORY
        lit_noise = variance_at(level + AT_SLOPES * location.amplitude, noise)
        told = 0.5 * lent / variance
        share = 1.0 - SHRINKAGE / max(told, SHRINKAGE)
        white = max(total / ((window.unlit.size - 1) * variance) - 1.0, 0.0)
        self._sums += (
            1.0, height, height**2,
            lit_noise / variance, told, share * told, share**2 * told,
            residual_variance(share, white),
            product, square - count * variance, 2.0 * variance * max(square, count * variance),
            *_followed(*compared, limit, variance),
        )
        self._judge()

    def _judge(self) -> None:
        """Set the growth by the sums."""
        self.growth = 1.0
        windows, height, heights = self._sums[:3].tolist()
        if windows < FEWEST_WINDOWS:
            return
        if height > 0.0 and height**2 > ALWAYS * windows * heights:
            return  # the light itself is in the unlit frames: other models tell what that does
        means = self._sums[3:8] / windows
        lit_noise, told, shared, shared_twice, added = means.tolist()
        products, texture, deviation, *followed = self._sums[8:].tolist()
        # Each window gives the mean of two chi-squares.
        power = told - 1.0
        if power < SIGMAS * told / math.sqrt(windows) or texture < SIGMAS * math.sqrt(deviation):
            return
        surely = _moves(FOLLOWED_SIGMAS, *followed)
        if not surely and not _moves(MOVING_SIGMAS, products, texture, deviation):
            return
        known = min(max(products / texture, 0.0), 1.0) * power / told
        total = lit_noise + power + shared_twice - 2.0 * known * shared
        growth = total / (lit_noise + added)
        if growth > (LEAST_GROWTH if surely else LEAST_UNSURE_GROWTH):
            self.growth = growth

    def doubted(self, location: Location) -> Location:
        """Return a location with the covariance that it has before such a texture."""
        # What the misfit has let it grow by it need not grow again.
        growth = self.growth / (max(location.chi2, 1.0) if location.warning else 1.0)
        if growth <= 1.0:
            return location
        return replace(location, covariance=growth * location.covariance)


def _moves(sigmas: float, products: float, texture: float, deviation: float) -> bool:
    """Tell whether two pictures have less in common than one of them has."""
    return texture - products > sigmas * math.sqrt(deviation) > 0.0


def _as_bright(product: float, first: float, second: float, noise: float) -> float:
    """
    Return the products of two pictures; a first one that is darker is made as bright as the other.

    Lamps may light the scene differently in each; `first`, `second` and `noise` are the squares
    of the two and of their noise, DN^2. A brighter one does not seem to have moved, and may be so
    by the wings of the light.
    """
    if not second > first > (1.0 + STRONG) * noise:
        return product
    return product * math.sqrt((second - noise) / (first - noise))


def _followed(
    before: UnlitWindow | None, now: UnlitWindow, limit: float, variance: float
) -> tuple[float, float, float]:
    """
    Return what the unlit windows of two flashes have in common, without the lights' places.

    Products of the two; squares of the one, less noise; and their variance; 0 for too few pixels.
    """
    nothing = 0.0, 0.0, 0.0
    if before is None or not now.follows(before):
        return nothing
    both = shared(before, now, reach=REACH, least=2)
    if both is None:
        return nothing
    first, second, one, other = both
    count, product, before_square, square = _in_common(first, second, limit, one, other)
    if count < FEWEST_PX:
        return nothing
    return (
        _as_bright(product, before_square, square, count * variance),
        square - count * variance, 2.0 * variance * max(square, count * variance),
    )


def compile_texture() -> None:
    """Compile what looks at the windows, or load it."""
    picture = np.arange(49.0).reshape(7, 7)
    _in_common(picture, picture, math.inf, (3.0, 3.0, 1.0), (3.0, 3.0, 1.0))
    _told(picture, picture, math.inf, (3.0, 3.0), 1.0)
    residual_variance(0.5, 1.0)


@kernel
def _told(
    lit: Array, unlit: Array, limit: float, middle: tuple[float, float], sigma: float
) -> tuple[float, float, float, float, int, float, float, float]:
    """
    Return what a window tells of the texture behind a light.

    Returns
    -------
    tuple
        Mean of the unlit pixels, DN, and the sum of the squares of their departures from it, DN^2;
        the height of a pulse in them, DN; what their departures lend to its place, squared, DN^2;
        how many pixels there are about the light; and of these the sums of lit times unlit, of
        lit squared and of unlit squared, all without their means, DN^2.

    """
    height, width = lit.shape
    total, usable = 0.0, 0
    one, other, count = 0.0, 0.0, 0
    for j in range(height):
        for i in range(width):
            if lit[j, i] < limit and unlit[j, i] < limit:
                total += unlit[j, i]
                usable += 1
                dx, dy = i - middle[0], j - middle[1]
                if (dx * dx + dy * dy) / (sigma * sigma) > REACH * REACH:
                    one += lit[j, i]
                    other += unlit[j, i]
                    count += 1
    if count < FEWEST_PX:
        return 0.0, 0.0, 0.0, 0.0, count, 0.0, 0.0, 0.0
    mean, one, other = total / usable, one / count, other / count
    along, across, along_square, across_square = 0.0, 0.0, 0.0, 0.0
    product, lit_square, square = 0.0, 0.0, 0.0
    squared, sums, pulses, pulse_squares = 0.0, 0.0, 0.0, 0.0
    for j in range(height):
        for i in range(width):
            if lit[j, i] < limit and unlit[j, i] < limit:
                dx, dy = i - middle[0], j - middle[1]
                squares = (dx * dx + dy * dy) / (sigma * sigma)
                pulse = math.exp(-0.5 * squares)
                squared += (unlit[j, i] - mean) ** 2
                sums += pulse * (unlit[j, i] - mean)
                pulses += pulse
                pulse_squares += pulse * pulse
                along += dx * pulse * (unlit[j, i] - mean)
                across += dy * pulse * (unlit[j, i] - mean)
                along_square += (dx * pulse) ** 2
                across_square += (dy * pulse) ** 2
                if squares > REACH * REACH:
                    product += (lit[j, i] - one) * (unlit[j, i] - other)
                    lit_square += (lit[j, i] - one) ** 2
                    square += (unlit[j, i] - other) ** 2
    lent = along * along / max(along_square, 1e-12) + across * across / max(across_square, 1e-12)
    height_found = sums / max(pulse_squares - pulses * pulses / usable, 1e-12)
    return mean, squared, height_found, lent, count, product, lit_square, square


@kernel
def _in_common(
    first: Array, second: Array, limit: float, one: tuple[float, float, float],
    other: tuple[float, float, float],
) -> tuple[int, float, float, float]:
    """
    Return what two pictures have in common, without what lies within a radius of two places.

    Returns
    -------
    tuple
        How many pixels there are; and of these the sums of first times second, of first squared
        and of second squared, all without their means, DN^2.

    """
    height, width = first.shape
    used = np.zeros((height, width), dtype=np.uint8)
    a, b, count = 0.0, 0.0, 0
    for j in range(height):
        for i in range(width):
            if (
                first[j, i] < limit and second[j, i] < limit
                and math.hypot(i - one[0], j - one[1]) > one[2]
                and math.hypot(i - other[0], j - other[1]) > other[2]
            ):
                used[j, i] = 1
                a += first[j, i]
                b += second[j, i]
                count += 1
    product, before, square = 0.0, 0.0, 0.0
    for j in range(height):
        for i in range(width):
            if used[j, i]:
                product += (first[j, i] - a / count) * (second[j, i] - b / count)
                before += (first[j, i] - a / count) ** 2
                square += (second[j, i] - b / count) ** 2
    return count, product, before, square
