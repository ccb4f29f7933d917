"""How noise may have been put on the thesis' pulses: what its text leaves open."""

from __future__ import annotations

from dataclasses import dataclass

from blob_tracker.studies.chapters_2_to_4.sampled_pulse import Numbers, rounded
import numpy as np


@dataclass(frozen=True)
class Reading:
    """
    One way to put noise of 1 DN on a pulse.

    Parameters
    ----------
    says : str
        In words.
    before : bool
        The noise is added before the rounding; else after it.
    last : str
        What is done to the sum: 'cast' (`rounded`), 'nearest', or 'nothing'.
    dark : str
        What is done to pixels below zero: 'kept', 'zero', or 'folded' to their absolute value.
    left_out : bool
        Pixels that are not above zero are left out of the SNR, as they are of a logarithm.

    """

    says: str
    before: bool
    last: str
    dark: str
    left_out: bool

    def apply(self, clean: Numbers, random: np.random.Generator) -> tuple[Numbers, Numbers]:
        """Return what is seen of a clean pulse, DN, and the error that counts in its SNR."""
        noise = random.standard_normal(clean.shape)
        seen = clean + noise if self.before else rounded(clean) + noise
        if self.last == 'cast':
            seen = rounded(seen)
        elif self.last == 'nearest':
            seen = np.rint(seen)
        if self.dark == 'zero':
            seen = np.maximum(seen, 0.0)
        elif self.dark == 'folded':
            seen = np.abs(seen)
        error = seen - clean
        if self.left_out:
            error = np.where(seen > 0.0, error, 0.0)
            seen = np.maximum(seen, 0.0)
        return seen, error


# The first is the one that the tables show; the others were tried beside it.
CENTROID_READINGS = (
    Reading('noise, then rounded by a cast; pixels below zero kept', True, 'cast', 'kept', False),
    Reading('noise, then rounded to nearest; below zero kept', True, 'nearest', 'kept', False),
    Reading('noise, then rounded to nearest; below zero set to 0', True, 'nearest', 'zero', False),
    Reading('noise, then rounded to nearest; absolute value', True, 'nearest', 'folded', False),
    Reading('rounded, then noise; below zero kept', False, 'nothing', 'kept', False),
    Reading('rounded, noise, rounded by a cast; below zero kept', False, 'cast', 'kept', False),
)
LOGARITHM_READINGS = (
    Reading('noise, then rounded; pixels not above zero left out', True, 'cast', 'kept', True),
    Reading('noise, then rounded; all pixels in the SNR', True, 'cast', 'kept', False),
    Reading('noise, then rounded to nearest; absolute value', True, 'nearest', 'folded', True),
    Reading('rounded, then noise; not above zero left out', False, 'nothing', 'kept', True),
    Reading('rounded, noise, rounded; not above zero left out', False, 'cast', 'kept', True),
)
