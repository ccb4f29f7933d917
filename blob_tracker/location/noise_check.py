"""The configured noise, held against the windows of a light."""

from __future__ import annotations

from dataclasses import replace
from math import hypot, inf, log, sqrt

from blob_tracker.kernel import Array, kernel
from blob_tracker.location.interpolated import doubted
from blob_tracker.location.likelihood import empty_profiles, fill_profile
from blob_tracker.location.moving_texture import compile_texture, MovingTexture
from blob_tracker.location.noise import noise_in_words, pixel_variance
from blob_tracker.location.stamp_jitter import compile_jitter, StampJitter
from blob_tracker.location.unlit_window import ComparedWindows, shared, UnlitWindow
from blob_tracker.types import Location, SensorNoise, Window
import numpy as np

CONTRADICTION = 1.2  # ratio of two variances; calibrations differ by less
SIGNIFICANT_SIGMA = 3.5
MEMORY = 256  # windows that were looked at, after which one weighs 1/e
LEAST_DOF = 500.0  # differences of pixels, which tell a variance to 9 %
LEAST_ALIKE_DOF = 150.0  # which tell a correlation to 0.06
ENOUGH_DOF, EVERY = 4000.0, 8  # beyond which every eighth window is looked at
LEAST_BRIGHT = 100.0  # pixels of the light: a variance to 14 %
FEWEST = 24  # px that two windows share: fewer say little
LARGEST = 64  # px of the sides of what is looked at: that is enough, and large lights cost time
REACH = 2.5  # sigma about the light that are left out: it may not be dark in the unlit frame
FARTHEST = 0.25  # px that the picture may move: first order is enough
UNSEEN = 0.05  # of the variance, that such a motion may make
HIDDEN_DN2 = 0.24  # variance below which rounding hides the noise (EMVA 1288, section 6.6)
INTERPOLATED = 0.2  # the same: of a picture that was interpolated from every other pixel, and more
CORRELATED = 0.1  # between neighbours: pixels that were warped, compressed or cleared of noise
FLATTEST = 0.05  # of the configured slope of the variance: what is measured as less is chance
# Of the longest column of a fit: what is left of one that the others make up is rounding.
DEPENDENT_PICTURE, DEPENDENT_PULSE = 1e-9, 1e-6


class NoiseCheck:
    """
    Measure the noise on the windows of a light, and say where the configured one is not it.

    The unlit pixels of two windows that follow each other differ by noise, by what the light of
    the room changed (a constant, and a part of the picture) and by what the picture moved (its
    derivatives): what is left of a fit of these is the variance at the level behind the light. It
    is not used where neighbours are correlated, or hidden by rounding. How the variance grows
    from there to the light's peak is told by the residuals of the pulse in the lit pixels,
    each over its share 1 - h of degrees of freedom, h the leverage; as a pulse of another shape
    leaves more than noise, the slope is taken between that of another black level and that of
    another gain.

    Only where the configured variance is off by more than 1.2, and 3.5 standard deviations, is
    the measured noise used: a right configuration is left as it is, bit for bit. All comes from
    windows in their order, so that a bag has the same numbers in one process and in three.

    Noise that is alike in neighbouring pixels tells that the picture was interpolated from a
    colour mosaic; and the unlit pixels tell whether the texture behind the light moves
    (`MovingTexture`), and the places whether its stamps jitter (`StampJitter`). All are in the
    covariance that `doubted` returns.

    Parameters
    ----------
    configured : SensorNoise
        Of one frame.

    Attributes
    ----------
    noise : SensorNoise
        To be used for the next window.
    warning : str
        What is wrong and what to set; '' where the configured noise is right, or not tested yet.

    """

    def __init__(self, configured: SensorNoise) -> None:
        self.configured = configured
        self.noise = configured
        self.warning = ''
        self._interpolated = False
        self._texture = MovingTexture()
        self._jitter = StampJitter()
        self._compared = ComparedWindows(EVERY)
        # dof, and dof times level and variance; products of neighbours and their count; of the
        # light's pixels 1 - h, and that times level and variance.
        self._sums = np.zeros(8)
        self._windows = 0
        self._compressed = False

    def configure(self, noise: SensorNoise) -> None:
        """Hold another noise against what was seen so far."""
        self.configured = noise
        self._judge()

    def doubted(self, window: Window, location: Location) -> Location:
        """Return the location of a window with the doubt of what the last ones have shown."""
        if self._interpolated:
            location = doubted(location, window.binning)
        return self._jitter.doubted(self._texture.doubted(location))

    def add(self, window: Window, location: Location) -> None:
        """
        Take the next window.

        Parameters
        ----------
        window : Window
            Lit and unlit pixels, DN.
        location : Location
            Of its light.

        """
        if window.unlit is None:
            return
        self._texture.add(window, location, self.noise)
        self._compressed = window.added_noise > 0.0  # what that does to a place is known
        self._windows += 1
        compared = self._compared.take(
            window, location, self._windows, rests=self._sums.item(0) > ENOUGH_DOF)
        if compared is None:
            return
        before, now = compared
        if before is None or not now.follows(before):
            return
        limit = inf if window.saturation is None else float(window.saturation)
        found = _unlit_variance(before, now, limit)
        if found is None:
            return
        dof, level, variance, product, neighbours = found
        self._sums *= 1.0 - 1.0 / MEMORY
        looks = window.looks
        self._sums[:3] += dof, dof * level / looks, dof * variance / looks
        self._sums[3:5] += product, neighbours
        self._sums[5:] += _bright(
            window, location, *window.to_window(location.x, location.y), self.configured)
        self._judge()

    def _judge(self) -> None:
        """Say whether the configured noise is that of the windows, and which one is."""
        self.noise, self.warning = self.configured, self._texture.warning
        self._interpolated = False
        dof = self._sums[0]
        if dof < LEAST_ALIKE_DOF:
            return
        level, variance = (float(each) for each in self._sums[1:3] / dof)
        if variance < HIDDEN_DN2:
            return
        alike = float(self._sums[3] / (self._sums[4] * variance))
        if abs(alike) > CORRELATED:
            self._interpolated = (
                alike > INTERPOLATED and not self._compressed and not self._texture.warning
            )
            if self._interpolated:
                self.warning = (
                    f'the noise of neighbouring pixels is alike (correlation {alike:.2f}): the '
                    'picture was interpolated from a colour mosaic, smoothed, or compressed with '
                    'loss (as the codecs of most videos do), and a narrow light is not where it '
                    "seems: take the sensor's own samples (an encoding bayer_*, see channel), "
                    'record them without loss, and switch sharpening and noise reduction off'
                )
            return
        if dof < LEAST_DOF:
            return
        configured = float(pixel_variance(np.array(level), self.configured))
        ratio = variance / configured
        # Each frame is in two differences: half as many are independent.
        sigma = sqrt(4.0 / dof)
        if abs(log(ratio)) < log(CONTRADICTION) + SIGNIFICANT_SIGMA * sigma:
            return
        self.noise = self._measured(level, variance)
        self.warning = (
            f'the unlit pixels have {ratio:.2g} times the variance of the configured noise '
            f'({noise_in_words(self.configured)}) at {level:.0f} DN; '
            f'{noise_in_words(self.noise)} is used instead. Set noise.gain, noise.read_noise and '
            'noise.black_level; python3 -m blob_tracker calibrate noise measures them'
            + ('' if ratio > 1.0 else '. Or the camera takes out noise: switch that off')
        )

    def _measured(self, level: float, variance: float) -> SensorNoise:
        """Return the noise of this variance at this level that is near the configured one."""
        given = self.configured
        constant = given.read_noise**2 + 1.0 / 12.0
        by_black = 1.0 / given.gain
        by_gain = by_black
        if level > given.black_level:
            by_gain = max((variance - constant) / (level - given.black_level), 0.0)
        slope = max(by_black, by_gain)
        count, levels, variances = map(float, self._sums[5:])
        if count > LEAST_BRIGHT and levels / count > level + 1.0:
            bright = levels / count
            told = (variances / count - variance) / (bright - level)
            slope = min(max(told, min(by_black, by_gain)), slope)
        slope = max(slope, FLATTEST * by_black)
        if slope == 0.0:  # no shot noise, as configured
            return replace(given, read_noise=sqrt(variance - 1.0 / 12.0))
        black_level = level - (variance - constant) / slope
        read_noise = given.read_noise
        if black_level > level:
            black_level, read_noise = level, sqrt(variance - 1.0 / 12.0)
        elif black_level < 0.0:
            black_level, read_noise = 0.0, sqrt(max(variance - 1.0 / 12.0 - level * slope, 0.0))
        return SensorNoise(1.0 / slope, read_noise, black_level)


def _unlit_variance(
    before: UnlitWindow, now: UnlitWindow, limit: float
) -> tuple[float, float, float, float, float] | None:
    """Return dof, level, variance, and the products of neighbours with their count; or None."""
    both = shared(before, now, reach=REACH, least=4, most=LARGEST)
    if both is None:
        return None
    first, second, one, other = both
    dof, level, variance, motion, slopes, product, neighbours = _differ(
        first, second, limit, one, other)
    if dof == 0.0 or (motion > FARTHEST and motion**2 * slopes > UNSEEN * 2.0 * variance):
        return None
    return dof, level, variance, product, neighbours


def _bright(
    window: Window, location: Location, x: float, y: float, noise: SensorNoise
) -> tuple[float, float, float]:
    """Return 1 - h of the light's pixels, that times their level, and the residuals' squares."""
    assert window.unlit is not None
    if max(window.unlit.shape) > LARGEST or location.saturated or location.sigma <= 0.0:
        return 0.0, 0.0, 0.0
    looks = window.looks
    share, level, squares = _residuals(
        np.ascontiguousarray(window.lit, dtype=float) / looks,
        np.ascontiguousarray(window.unlit, dtype=float),
        (x, y, location.sigma, location.amplitude / looks, location.background / looks),
        (noise.gain, noise.read_noise**2 + 1.0 / 12.0, noise.black_level),
    )
    # The mean of several looks has so much less variance.
    return share, level, looks * squares


def compile_check() -> None:
    """Compile what looks at the windows, or load it."""
    compile_texture()
    compile_jitter()
    picture = np.arange(49.0).reshape(7, 7)
    _differ(picture, picture[::-1].copy(), inf, (3.0, 3.0, 1.0), (3.0, 3.0, 1.0))
    _residuals(picture, picture, (3.0, 3.0, 1.0, 10.0, 1.0), (1.0, 1.0, 0.0))


@kernel
def _differ(
    first: Array, second: Array, limit: float, one: tuple[float, float, float],
    other: tuple[float, float, float],
) -> tuple[float, float, float, float, float, float, float]:
    """
    Fit how two pictures of one scene differ, without what lies within a radius of two places.

    Returns
    -------
    tuple of float
        Degrees of freedom, 0 where the pictures are equal or too few pixels are left; mean level,
        DN; variance of a pixel, DN^2; by how much the picture moved, px; mean square of its
        slopes, (DN/px)^2; and the products of neighbours with their count.

    """
    height, width = first.shape
    used = np.zeros((height, width), dtype=np.uint8)
    mean = np.empty((height, width))
    count, equal = 0, True
    for j in range(height):
        for i in range(width):
            a, b = first[j, i], second[j, i]
            mean[j, i] = 0.5 * (a + b)
            equal = equal and a == b
            if (
                0.0 < a < limit and 0.0 < b < limit
                and hypot(i - one[0], j - one[1]) > one[2]
                and hypot(i - other[0], j - other[1]) > other[2]
            ):
                used[j, i] = 1
                count += 1
    if count < FEWEST or equal:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    columns = np.empty((4, count))
    rest = np.empty(count)
    level, slopes, k = 0.0, 0.0, 0
    for j in range(height):
        above, below = max(j - 1, 0), min(j + 1, height - 1)
        for i in range(width):
            if used[j, i]:
                left, right = max(i - 1, 0), min(i + 1, width - 1)
                along_x = (mean[j, right] - mean[j, left]) / (right - left)
                along_y = (mean[below, i] - mean[above, i]) / (below - above)
                columns[0, k] = 1.0
                columns[1, k] = mean[j, i]
                columns[2, k] = along_x
                columns[3, k] = along_y
                rest[k] = second[j, i] - first[j, i]
                level += mean[j, i]
                slopes += along_x * along_x + along_y * along_y
                k += 1
    triangle = np.zeros((4, 4))
    shares = np.empty(4)
    _orthonormalise(columns, DEPENDENT_PICTURE, triangle)
    _take_off(columns, rest, shares)
    moved_y = shares[3] / triangle[3, 3] if triangle[3, 3] > 0.0 else 0.0
    moved_x = 0.0
    if triangle[2, 2] > 0.0:
        moved_x = (shares[2] - triangle[2, 3] * moved_y) / triangle[2, 2]
    picture = np.zeros((height, width))
    squares, k = 0.0, 0
    for j in range(height):
        for i in range(width):
            if used[j, i]:
                picture[j, i] = rest[k]
                squares += rest[k] * rest[k]
                k += 1
    product, neighbours = 0.0, 0
    for j in range(height):
        for i in range(width):
            if i > 0:
                product += picture[j, i] * picture[j, i - 1]
                neighbours += used[j, i] & used[j, i - 1]
            if j > 0:
                product += picture[j, i] * picture[j - 1, i]
                neighbours += used[j, i] & used[j - 1, i]
    dof = count - 4
    return (
        float(dof), level / count, 0.5 * squares / dof, hypot(moved_x, moved_y),
        slopes / (2 * count), 0.5 * product, float(neighbours),
    )


@kernel
def _residuals(
    lit: Array, unlit: Array, pulse: tuple[float, float, float, float, float],
    noise: tuple[float, float, float],
) -> tuple[float, float, float]:
    """
    Return what a pulse leaves of the pixels above half its height.

    Parameters
    ----------
    lit, unlit : (h, w) arrays
        DN.
    pulse : tuple of float
        x, y and sigma, px; amplitude and background, DN.
    noise : tuple of float
        Gain, the variance without light, DN^2, and the black level.

    Returns
    -------
    tuple of float
        1 - h of them, h the leverage; that times their level; their residuals' squares, DN^2.

    """
    height, width = lit.shape
    x, y, sigma, amplitude, background = pulse
    gain, floor, black_level = noise
    across, down = empty_profiles(height, width)
    fill_profile(x, sigma, across)
    fill_profile(y, sigma, down)
    mean_unlit = unlit.sum() / unlit.size
    columns = np.empty((6, lit.size))
    rest = np.empty(lit.size)
    deviation = np.empty(lit.size)
    for j in range(height):
        for i in range(width):
            k = j * width + i
            shape = down[0, j] * across[0, i]
            mean = background + amplitude * shape
            deviation[k] = sqrt(max(mean - black_level, 0.0) / gain + floor)
            scale = 1.0 / deviation[k]
            columns[0, k] = scale
            columns[1, k] = scale * (unlit[j, i] - mean_unlit)
            columns[2, k] = scale * shape
            columns[3, k] = scale * down[0, j] * across[1, i]
            columns[4, k] = scale * down[1, j] * across[0, i]
            columns[5, k] = scale * (down[0, j] * across[2, i] + down[2, j] * across[0, i])
            rest[k] = scale * (lit[j, i] - mean)
    _orthonormalise(columns, DEPENDENT_PULSE, np.zeros((6, 6)))
    _take_off(columns, rest, np.empty(6))
    share, level, squares = 0.0, 0.0, 0.0
    for j in range(height):
        for i in range(width):
            k = j * width + i
            shape = down[0, j] * across[0, i]
            if shape <= 0.5:
                continue
            own = 1.0
            for p in range(6):
                own -= columns[p, k] * columns[p, k]
            share += own
            level += own * (background + amplitude * shape)
            squares += (rest[k] * deviation[k]) ** 2
    return share, level, squares


@kernel
def _orthonormalise(columns: Array, dependent: float, triangle: Array) -> None:
    """
    Make columns (k, n) orthonormal, each without those before it (Gram and Schmidt, modified).

    Of one that these make up to `dependent` of the longest column, nothing is left. The triangle
    of the QR factors is filled, 0 in the rows of such columns.
    """
    longest = 0.0
    for p in range(columns.shape[0]):
        longest = max(longest, sqrt((columns[p] * columns[p]).sum()))
    for p in range(columns.shape[0]):
        own = columns[p]
        for q in range(p):
            triangle[q, p] = (columns[q] * own).sum()
            own -= triangle[q, p] * columns[q]
        length = sqrt((own * own).sum())
        if length > dependent * longest:
            triangle[p, p] = length
            own /= length
        else:
            own[:] = 0.0


@kernel
def _take_off(columns: Array, rest: Array, shares: Array) -> None:
    """Take orthonormal columns (k, n) off what they are fitted to; `shares` tells their part."""
    for p in range(columns.shape[0]):
        shares[p] = (columns[p] * rest).sum()
        rest -= shares[p] * columns[p]
