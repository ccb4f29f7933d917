"""What lit up but is not the target: hot pixels, edges, lamps that flicker, things that move."""

from __future__ import annotations

import math

from blob_tracker.kernel import Array, kernel
from blob_tracker.segmentation.candidate import Candidate
import numpy as np

# The four neighbours of the peak pixel have a third of its height where sigma is 0.6 px, and more
# where it is wider; those of a hot pixel have none but noise.
LEAST_NEIGHBOUR_RATIO = 0.1
# Times as long as wide: a moving edge, a glint's streak or a band is longer, as far as adaptive
# moments follow (2.6); but for a streak that has a level and two ends.
MAX_ELONGATION = 2.5
NARROWEST_PX = 0.7  # px: below it the width is that of the pixel, and noise decides
MAX_MISFIT = 0.5  # a clipped or a square blob leaves 0.3; half a blob, an edge or a ring more
SAMPLED_SIGMA_PX = 0.9  # px of sigma, from which on pixels draw the shape of a blob
MAX_UNSAMPLED_MISFIT = 1.0  # below it
# A lamp on the mains does not go dark within an exposure: more of it stands than comes. Of a
# flash nothing is left but the background, and that is no higher than its own texture.
MAX_UNLIT_RATIO = 1.0
TEXTURE_SIGMA = 3.0  # standard deviations
# The edge of something slow rises as little as this over the step that it makes in the scene.
LEAST_TEXTURE_RATIO = 1.0
# Times that: a target that is followed may pass in front of something bright
FOLLOWED_ALLOWANCE = 3.0
# Two lit frames of a moving light leave a rise and an equal fall beside each other; a true flash
# leaves no fall but noise. Half-way between the two tells them apart.
MAX_FALL_RATIO = 0.5
# Standard deviations: the mean of 2 x 2 pixels falls by 2.5 at most by noise
NOISE_FALL_SIGMA = 4.0

# Haze and walls are lit up far about a light: what holds a blob that is so many times narrower
GLOW_WIDTH_RATIO = 3.0
GLOW_REACH_SIGMA = 3.0  # within so many sigma of its middle is the glow of that one


# What may speak against a candidate, in the order in which it is asked. From GLOW on it is the
# glow of the light in the row fault - GLOW.
(
    NOTHING, LONE_PIXEL, LONG, FALL, NO_BLOB, RESTLESS, STANDING, TEXTURE, CLIPPED, GLOW,
) = range(10)
FIELDS = Candidate._fields.index('rejected')  # that are measured
FIELD = {name: place for place, name in enumerate(Candidate._fields)}
X, Y, COLUMN, ROW = (FIELD[n] for n in ('x', 'y', 'column', 'row'))
HEIGHT, AMPLITUDE, MISFIT, SNR = (FIELD[n] for n in ('height', 'amplitude', 'misfit', 'snr'))
MAJOR, MINOR, STREAK = (FIELD[n] for n in ('sigma_major', 'sigma_minor', 'streak'))
NEIGHBOURS, FELL, WAS_CLIPPED = (FIELD[n] for n in ('neighbour_ratio', 'fall', 'clipped'))
UNLIT, SCENE, NOISE, AROUND = (
    FIELD[n] for n in ('unlit_amplitude', 'texture', 'noise', 'surround_noise')
)


@kernel
def fault(row: Array, followed: bool, min_snr: float) -> int:
    """
    Return what speaks against a candidate, one of the above.

    Parameters
    ----------
    row : (22,) array
        Its fields, see `Candidate`.
    followed : bool
        Whether it is where a target is expected, by what was seen before.
    min_snr : float
        Least SNR in the matched filter.

    """
    if row[NEIGHBOURS] < LEAST_NEIGHBOUR_RATIO:
        return LONE_PIXEL
    if row[MAJOR] > MAX_ELONGATION * max(row[MINOR], NARROWEST_PX) and row[STREAK] == 0.0:
        return LONG
    if row[FELL] > max(MAX_FALL_RATIO * row[HEIGHT], NOISE_FALL_SIGMA * row[NOISE]):
        return FALL
    if row[MISFIT] > (MAX_MISFIT if row[MINOR] > SAMPLED_SIGMA_PX else MAX_UNSAMPLED_MISFIT):
        return NO_BLOB
    if row[SNR] * row[NOISE] < min_snr * row[AROUND]:
        return RESTLESS
    standing = max(MAX_UNLIT_RATIO * row[AMPLITUDE], TEXTURE_SIGMA * row[SCENE])
    if row[UNLIT] > standing * (FOLLOWED_ALLOWANCE if followed else 1.0):
        return STANDING
    if not followed and row[AMPLITUDE] < LEAST_TEXTURE_RATIO * row[SCENE]:
        return TEXTURE
    return CLIPPED if row[WAS_CLIPPED] != 0.0 else NOTHING


def in_words(fault: int, candidate: Candidate) -> str:
    """Say why a candidate is no target; empty if nothing speaks against it."""
    height = candidate.height
    if fault == LONE_PIXEL:
        return (
            f'a lone pixel rose by {height:.0f} DN: it is hot, or was hit by a particle; or a '
            'light is narrower than a pixel, or a cell of the colour mosaic: defocus it a little'
        )
    if fault == LONG:
        return (
            f'what lit up is {candidate.sigma_major:.1f} px long and '
            f'{candidate.sigma_minor:.1f} px wide (sigma): an edge that moved, or a band'
        )
    if fault == FALL:
        return (
            f'a rise of {height:.0f} DN beside a fall of {candidate.fall:.0f} DN: '
            'something moved, or the light was on in both frames'
        )
    if fault == NO_BLOB:
        return (
            f'a rise of {height:.0f} DN that is not a blob: a Gaussian leaves '
            f'{100 * candidate.misfit:.0f} % of it'
        )
    if fault == RESTLESS:
        return (
            f'a rise of {height:.0f} DN where everything around it changes by '
            f"{candidate.surround_noise:.1f} DN: the scene's own, or the codec's"
        )
    if fault == STANDING:
        return (
            f'a rise of {candidate.amplitude:.0f} DN on {candidate.unlit_amplitude:.0f} DN that '
            'were there before: a lamp that flickers'
        )
    if fault == TEXTURE:
        return (
            f'a rise of {candidate.amplitude:.0f} DN where the scene itself varies by '
            f'{candidate.texture:.0f} DN: an edge that moved a little'
        )
    if fault == CLIPPED:
        return (
            f'a rise of {height:.0f} DN beside pixels that were clipped before: the rim of '
            'the sun or of a lamp'
        )
    return ''


def glow_in_words(glow: Candidate, light: Candidate) -> str:
    """Say of which light a glow is one."""
    return (
        f'a glow {glow.sigma_major:.0f} px wide (sigma) about the light at '
        f'({light.x:.0f}, {light.y:.0f}): haze or a wall that it lights up'
    )


@kernel
def mark_glows(table: Array) -> None:
    """
    Reject what is the glow of another light: its fault becomes GLOW and the row of that light.

    Parameters
    ----------
    table : (n, 23) array
        What lit up in one frame, rejected or not, see `measure_peaks`.

    """
    lights = np.flatnonzero(table[:, FIELDS] == NOTHING)
    narrowest = np.inf
    for k in lights:
        narrowest = min(narrowest, table[k, MAJOR])
    for k in lights:
        if table[k, MINOR] <= GLOW_WIDTH_RATIO * narrowest:
            continue
        for light in lights:
            distance = math.hypot(table[light, X] - table[k, X], table[light, Y] - table[k, Y])
            if (
                table[k, MINOR] > GLOW_WIDTH_RATIO * table[light, MAJOR]
                and distance < GLOW_REACH_SIGMA * table[k, MAJOR]
            ):
                table[k, FIELDS] = GLOW + light
                break
