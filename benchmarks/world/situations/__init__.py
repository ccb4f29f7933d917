"""What happens outside the lab, a file for each kind; see `Situation`."""

from __future__ import annotations

from benchmarks.world.situation import Situation
from benchmarks.world.situations import (
    afterglow, bad_pixels, colour_filters, coma, defocus, dimmed, flood, glow, jpeg, leak,
    many_lights, mirror_image, misfit, moving_texture, noise_reduction, overexposed, reflection,
    repeated_frames, streak, switched, undersampled, wrong_noise,
)

KINDS = (
    afterglow, switched, dimmed, noise_reduction, mirror_image, reflection, glow, overexposed,
    bad_pixels, repeated_frames, many_lights, flood, streak, defocus, coma, leak, colour_filters,
    jpeg, undersampled, moving_texture, misfit, wrong_noise,
)


def situations() -> dict[str, Situation]:
    """Return all situations by name, in the order of their numbers."""
    return {each.name: each for kind in KINDS for each in kind.SITUATIONS}
