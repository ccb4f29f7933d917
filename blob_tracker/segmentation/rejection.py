"""What lit up but is not the target: hot pixels, edges, lamps that flicker, things that move."""

from __future__ import annotations

from collections.abc import Sequence
import math

from blob_tracker.segmentation.candidate import Candidate

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


def reject(candidate: Candidate, followed: bool, min_snr: float = 0.0) -> str:
    """
    Say why a candidate is no target.

    Parameters
    ----------
    candidate : Candidate
        What lit up.
    followed : bool
        Whether it is where a target is expected, by what was seen before.
    min_snr : float
        Least SNR in the matched filter.

    Returns
    -------
    str
        Empty where nothing speaks against it.

    """
    height = candidate.height
    if candidate.neighbour_ratio < LEAST_NEIGHBOUR_RATIO:
        return (
            f'a lone pixel rose by {height:.0f} DN: it is hot, or was hit by a particle; or a '
            'light is narrower than a pixel, or a cell of the colour mosaic: defocus it a little'
        )
    long = candidate.sigma_major > MAX_ELONGATION * max(candidate.sigma_minor, NARROWEST_PX)
    if long and not candidate.streak:
        return (
            f'what lit up is {candidate.sigma_major:.1f} px long and '
            f'{candidate.sigma_minor:.1f} px wide (sigma): an edge that moved, or a band'
        )
    if candidate.fall > max(MAX_FALL_RATIO * height, NOISE_FALL_SIGMA * candidate.noise):
        return (
            f'a rise of {height:.0f} DN beside a fall of {candidate.fall:.0f} DN: '
            'something moved, or the light was on in both frames'
        )
    shaped = candidate.sigma_minor > SAMPLED_SIGMA_PX
    if candidate.misfit > (MAX_MISFIT if shaped else MAX_UNSAMPLED_MISFIT):
        return (
            f'a rise of {height:.0f} DN that is no blob: a Gaussian leaves '
            f'{100 * candidate.misfit:.0f} % of it'
        )
    if candidate.snr * candidate.noise < min_snr * candidate.surround_noise:
        return (
            f'a rise of {height:.0f} DN where all about it changes by '
            f"{candidate.surround_noise:.1f} DN: the scene's own, or the codec's"
        )
    standing = max(MAX_UNLIT_RATIO * candidate.amplitude, TEXTURE_SIGMA * candidate.texture)
    if candidate.unlit_amplitude > standing * (FOLLOWED_ALLOWANCE if followed else 1.0):
        return (
            f'a rise of {candidate.amplitude:.0f} DN on {candidate.unlit_amplitude:.0f} DN that '
            'were there before: a lamp that flickers'
        )
    if not followed and candidate.amplitude < LEAST_TEXTURE_RATIO * candidate.texture:
        return (
            f'a rise of {candidate.amplitude:.0f} DN where the scene itself varies by '
            f'{candidate.texture:.0f} DN: an edge that moved a little'
        )
    if candidate.clipped:
        return (
            f'a rise of {height:.0f} DN beside pixels that were clipped before: the rim of '
            'the sun or of a lamp'
        )
    return ''


def without_glows(candidates: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """
    Return the candidates with those rejected that are the glow of another one.

    Parameters
    ----------
    candidates : sequence of Candidate
        What lit up in one frame, rejected or not.

    """
    lights = [each for each in candidates if not each.rejected]
    if len(lights) < 2:
        return tuple(candidates)
    narrowest = min(each.sigma_major for each in lights)
    out = []
    for each in candidates:
        if not each.rejected and each.sigma_minor > GLOW_WIDTH_RATIO * narrowest:
            for light in lights:
                distance = math.hypot(light.x - each.x, light.y - each.y)
                if (
                    each.sigma_minor > GLOW_WIDTH_RATIO * light.sigma_major
                    and distance < GLOW_REACH_SIGMA * each.sigma_major
                ):
                    each = each._replace(rejected=(
                        f'a glow {each.sigma_major:.0f} px wide (sigma) about the light at '
                        f'({light.x:.0f}, {light.y:.0f}): haze or a wall that it lights up'
                    ))
                    break
        out.append(each)
    return tuple(out)
