"""Photon transfer: gain, dark noise, saturation and non-uniformity from pairs of flat frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

from blob_tracker.calibration.frame_pair import CLIPPED, Pair, PhotonTransferError, PILED_UP
from blob_tracker.calibration.noise_line import fit_noise_line, NoiseLine, QUANTISATION
from blob_tracker.calibration.non_uniformity import dsnu_of, linearity_of, prnu_of
from blob_tracker.calibration.system_gain import RANGE, system_gain
from blob_tracker.types import SensorNoise
import numpy as np
from numpy.typing import NDArray

FALL = 0.9  # of the variance before it: the transfer curve has passed its peak
CORRELATED = 0.05  # between neighbours' noise; row noise and crosstalk of good sensors is below
GROWS = 3.0  # standard deviations of the slope, that it must be above 0
BENT = 0.15  # slope gained or lost over the range, relative
NONLINEAR = 0.02  # mean relative deviation of the level from a line over the exposure


@dataclass(frozen=True)
class PhotonTransfer:
    """
    What photon transfer tells of a camera, each figure with its standard deviation.

    Parameters
    ----------
    line : NoiseLine
        Variance over the level above black: its foot is the temporal dark variance.
    system_gain : (float, float) or None
        K by the letter of EMVA 1288, DN per electron; None if dark frames are missing or wrong.
    black_level : (float, float) or None
        DN; None without dark frames, or where dark pixels are clipped at 0 DN.
    saturation : int
        DN of a clipped pixel.
    saturation_seen : bool
        Whether clipped pixels were seen; else `saturation` is what the values suggest.
    saturation_level : (float, float)
        Mean at the peak of the transfer curve, DN.
    capacity : (float, float)
        The same above black, electrons.
    prnu : (float, float) or None
        Photo response non-uniformity, part of the signal.
    dsnu : (float, float) or None
        Dark signal non-uniformity, electrons; None without usable dark frames.
    linearity_error : (float, float) or None
        Mean relative deviation of the level from a line over the exposure; None if fewer than
        three exposures between 5 and 95 % of saturation are known.
    pairs : tuple of Pair
        All, in order of their level.
    used : (n,) bool array
        Those that the line was fitted to.
    warnings : tuple of str
        What to know before one relies on it.

    Examples
    --------
    Without dark frames there is no black level, and what is told has a warning:

    >>> from blob_tracker.calibration.frame_pair import pair_of
    >>> from blob_tracker.simulation import FlatField, Sensor
    >>> field, random = FlatField(Sensor(), width=160, height=120), np.random.default_rng(1)
    >>> found = photon_transfer([
    ...     pair_of(field.frame(level, random), field.frame(level, random))
    ...     for level in (20.0, 60.0, 120.0, 160.0)  # DN
    ... ])
    >>> found.system_gain, found.black_level
    (None, None)
    >>> round(found.noise.gain), len(found.warnings)  # electrons a DN
    (40, 2)

    """

    line: NoiseLine
    system_gain: tuple[float, float] | None
    black_level: tuple[float, float] | None
    saturation: int
    saturation_seen: bool
    saturation_level: tuple[float, float]
    capacity: tuple[float, float]
    prnu: tuple[float, float] | None
    dsnu: tuple[float, float] | None
    linearity_error: tuple[float, float] | None
    pairs: tuple[Pair, ...]
    used: NDArray[np.bool_]
    warnings: tuple[str, ...]

    @property
    def noise(self) -> SensorNoise:
        """Gain, temporal dark noise and black level; where that is unknown, `NoiseLine.noise`."""
        if self.black_level is None:
            return self.line.noise
        return SensorNoise(self.line.gain, self.line.read_noise, self.black_level[0])


def photon_transfer(pairs: Sequence[Pair], saturation: int | None = None) -> PhotonTransfer:
    """
    Return gain, noise, saturation and non-uniformity from pairs at several levels.

    All pairs from dark to 70 % of saturation share the line

        s^2 = s_dark^2 + K (mean - mean_dark),

    EMVA 1288, eq. 15, fitted with the known variance of a variance as weight. The dark pairs are
    points of it at 0, so that their noise is taken off the others' and is part of the covariance.
    Where rounding or clipping at 0 DN hides the noise of a pair, that pair is left out; without a
    dark mean to trust, the black level counts as 0 DN.

    Parameters
    ----------
    pairs : sequence of Pair
        See `pair_of`; bright ones at two levels or more, or at one and dark ones.
    saturation : int, optional
        DN of a clipped pixel, where it is known.

    Returns
    -------
    PhotonTransfer
        What they tell.

    Raises
    ------
    PhotonTransferError
        If the pairs are all clipped, all of one level, or their variance does not grow.

    Examples
    --------
    A sensor of the virtual lab of 12 bits, 3.6 electrons a DN, 3 DN of read noise on 20 DN:

    >>> from blob_tracker.calibration.frame_pair import pair_of
    >>> from blob_tracker.simulation import FlatField, Sensor
    >>> noise = SensorNoise(gain=3.6, read_noise=3.0, black_level=20.0)
    >>> random = np.random.default_rng(1)
    >>> field = FlatField(Sensor(noise, bits=12), width=320, height=240)
    >>> found = photon_transfer([
    ...     pair_of(field.frame(level, random), field.frame(level, random), dark=level == 0.0)
    ...     for level in (0.0, 0.0, 100.0, 500.0, 1000.0, 2000.0, 4500.0)  # DN
    ... ])
    >>> round(found.noise.gain, 1), round(found.noise.read_noise, 1)  # electrons a DN, DN
    (3.6, 3.0)
    >>> found.saturation, found.saturation_seen
    (4095, True)

    """
    pairs = tuple(sorted(pairs, key=lambda each: (not each.dark, each.mean)))
    bright = [each for each in pairs if not each.dark]
    if not bright:
        raise PhotonTransferError('there are no bright frames; photon transfer needs some')
    warnings = _of_processing(pairs)
    full, seen = clipped_level(pairs, saturation)
    peak, falls = _peak(bright, full)
    if peak is None:
        raise PhotonTransferError(
            f'every bright pair is clipped at {full} DN; expose shorter or dim the light'
        )
    if falls and not (seen or saturation):
        # The well is full below the converter's range: pixels are wrong from there on.
        full, seen = round(peak.mean), True
    if not (seen or saturation):
        warnings.append(
            f'no pixel is clipped; the saturation of {full} DN is what the values suggest'
        )
    darks = [each for each in pairs if each.dark]
    known, black_of = _black_level(darks, warnings)
    black = known[0] if known else 0.0
    above = np.array([_above(each, black, black_of) for each in pairs])
    most = peak.mean if falls else float(full)
    used = np.array([
        each.shows_noise
        and level <= RANGE * (most - black)
        # A few hot pixels are at full scale in every frame.
        and (each.highest < full or each.at_highest < CLIPPED)
        for each, level in zip(pairs, above)
    ])
    if darks and not used[:len(darks)].any() and black_of:
        warnings.append(
            'rounding hides the noise of the dark frames; the dark noise is that of the line'
        )
    points = [each for each, taken in zip(pairs, used) if taken]
    levels = above[used]
    if len(points) < 2 or np.ptp(levels) < 0.02 * most:
        raise PhotonTransferError(
            f'{len(points)} of {len(pairs)} pairs show their noise below {RANGE:.0%} of the '
            f'saturation of {full} DN, all at one level; take pairs at several exposures, or of '
            'several brightnesses'
        )
    variances = np.array([each.variance for each in points])
    scatters = np.array([each.scatter for each in points])
    line = fit_noise_line(levels, variances, scatters)
    if line.slope < GROWS * sqrt(line.covariance[0, 0]):
        raise PhotonTransferError(
            f'the variance does not grow with the level: {variances[levels.argmin()]:.2f} DN^2 at '
            f'{levels.min():.0f} DN above black, {variances[levels.argmax()]:.2f} DN^2 at '
            f'{levels.max():.0f} DN; a camera that applies a gamma curve or takes out noise has '
            'no photon transfer: switch that off, or measure the curve first (calibrate response) '
            'and give it with --response'
        )
    standard = system_gain(bright, darks if black_of else [])
    if not line.fits:
        # Two ways to ask for one gain: neither is known better than they agree.
        line = line.turned(
            standard[0] if standard else float(np.polyfit(levels, variances, 1)[0])
        )
    warnings += _of_the_line(line, levels, variances, scatters)
    linearity = linearity_of(bright, black, most)
    if linearity is not None and linearity[0] > NONLINEAR:
        warnings.append(
            f'the level is off a line over the exposure by {linearity[0]:.1%}; is there a gamma '
            'curve, or did the light change?'
        )
    electrons, capacity_sigma = _capacity(peak.mean - black, line)
    below_next = [each.mean for each in bright if each.mean > peak.mean]
    step = (below_next[0] - peak.mean) if below_next else float(full) - peak.mean
    return PhotonTransfer(
        line=line,
        system_gain=standard,
        black_level=known,
        saturation=full,
        saturation_seen=seen,
        # It lies somewhere up to the next exposure.
        saturation_level=(peak.mean, max(step, 0.0) / sqrt(12.0)),
        capacity=(electrons, sqrt(capacity_sigma**2 + (step * line.gain) ** 2 / 12.0)),
        prnu=prnu_of(bright, darks if black_of else [], black, most),
        dsnu=dsnu_of(darks if black_of else [], line),
        linearity_error=linearity,
        pairs=pairs,
        used=used,
        warnings=tuple(warnings),
    )


def _of_processing(pairs: Sequence[Pair]) -> list[str]:
    """Warn of pixels that are not as the sensor gave them."""
    warnings = []
    worst = max((each for each in pairs if each.at_highest < PILED_UP),
                key=lambda each: abs(each.correlation), default=None)
    if worst is not None and abs(worst.correlation) > max(CORRELATED, 5.0 / sqrt(worst.count)):
        warnings.append(
            f"neighbours' noise is correlated ({worst.correlation:+.2f} at {worst.mean:.0f} DN): "
            'the frames were compressed, demosaiced, sharpened or cleared of noise, and no noise '
            'model holds for them; take raw frames'
        )
    step = int(np.gcd.reduce([each.step for each in pairs]))
    if step > 1:
        warnings.append(
            f'all values are multiples of {step}: the camera puts its bits into the upper ones, '
            'or stretched them; its rounding is coarser than the 1/12 DN^2 that is taken out'
        )
    return warnings


def clipped_level(pairs: Sequence[Pair], given: int | None = None) -> tuple[int, bool]:
    """
    Return the DN of a clipped pixel, and whether such pixels were seen.

    Parameters
    ----------
    pairs : sequence of Pair
        Where there is no pixel clipped, their highest one tells how many bits there are.
    given : int, optional
        The level, where it is known.

    Examples
    --------
    Of words of 16 bits that hold 12, none of which is clipped:

    >>> from blob_tracker.calibration.frame_pair import pair_of
    >>> random = np.random.default_rng(1)
    >>> pair = pair_of(*random.normal(3000.0, 20.0, (2, 48, 64)).astype(np.uint16))
    >>> clipped_level([pair])
    (4095, False)

    """
    highest = max(each.highest for each in pairs)
    if given is not None:
        return given, highest >= given
    if any(each.highest == highest and each.at_highest > PILED_UP for each in pairs):
        return highest, True
    bits = next(bits for bits in (8, 10, 12, 14, 16) if highest < 2**bits)
    return 2**bits - 1, False


def _peak(bright: Sequence[Pair], full: int) -> tuple[Pair | None, bool]:
    """Return the pair at the peak of the transfer curve, and whether the curve falls after it."""
    whole = [each for each in bright if each.highest < full or each.at_highest < PILED_UP]
    if not whole:
        return None, False
    for each, following in zip(whole, whole[1:]):
        if following.variance < FALL * each.variance and each.mean > 0.3 * full:
            return each, True
    return whole[-1], len(whole) < len(bright)


def _black_level(
    darks: Sequence[Pair], warnings: list[str]
) -> tuple[tuple[float, float] | None, dict[float, float]]:
    """Return mean and sigma of the dark level, DN, if known, and the level for each exposure."""
    sound = [each for each in darks if each.at_zero < CLIPPED]
    if len(sound) < len(darks):
        worst = max(each.at_zero for each in darks)
        warnings.append(
            f'{worst:.1%} of the dark pixels are clipped at 0 DN; their noise is left out. Raise '
            "the camera's black level until none are"
        )
    if not sound:
        if not darks:
            warnings.append('no dark frames: the black level is taken as 0 DN')
        return None, {}
    means = np.array([each.mean for each in sound])
    own = np.sqrt(sum(each.variance / (2.0 * each.count) for each in sound)) / means.size
    scatter = means.std(ddof=1) / sqrt(means.size) if means.size > 1 else 0.0
    # Where no noise spreads the pixels over the steps of rounding, all are rounded alike.
    rounding = 0.0 if any(each.shows_noise for each in sound) else QUANTISATION
    level = (float(means.mean()), sqrt(max(own, scatter) ** 2 + rounding))
    exposures = np.array([each.exposure or 0.0 for each in sound])
    return level, {
        float(each): float(means[exposures == each].mean()) for each in np.unique(exposures)
    }


def _above(pair: Pair, black: float, black_of: dict[float, float]) -> float:
    """Return the level above that of the dark frames of the same exposure, or of all of them."""
    if pair.dark:
        return 0.0
    return pair.mean - black_of.get(pair.exposure or 0.0, black)


def _of_the_line(
    line: NoiseLine,
    levels: NDArray[np.float64],
    variances: NDArray[np.float64],
    scatters: NDArray[np.float64],
) -> list[str]:
    """Warn of points that do not lie on a line."""
    warnings = []
    if not line.separates:
        warnings.append(
            'shot noise is so little of the variance that the gain is known to '
            f'{sqrt(line.covariance[0, 0]) / line.slope:.0%}; more frames measure it better'
        )
    if not line.fits:
        off = variances / (line.foot + line.slope * levels) - 1.0
        warnings.append(
            f'the points lie off the line by {sqrt(float((off**2).mean())):.1%} rms, more than '
            f'their noise (chi2 {line.chi2:.0f} for {line.dof}); the sigmas have grown by it'
        )
    if levels.size >= 4:
        x = levels / levels.max()
        sigmas = np.sqrt(scatters) * (line.foot + line.slope * levels)
        bend, slope, _ = np.polyfit(x, variances, 2, w=1.0 / sigmas)
        if abs(bend) > BENT * abs(slope) and not line.fits:
            warnings.append(
                f'the transfer curve bends: its slope changes by {2.0 * bend / slope:+.0%} over '
                'the range. The camera takes out noise, or is not linear (gamma): see calibrate '
                'response'
            )
    return warnings


def _capacity(level: float, line: NoiseLine) -> tuple[float, float]:
    """Return electrons at a level above black and the part of their sigma that the gain has."""
    return level * line.gain, level * sqrt(float(line.noise_covariance[0, 0]))
