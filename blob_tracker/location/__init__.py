"""Window -> Location: where in the picture the blob is, far below a pixel."""

from blob_tracker.location.effective_psf import EffectivePsf
from blob_tracker.location.estimates import Estimates
from blob_tracker.location.learn_pulse import learn_pulse, Learned
from blob_tracker.location.locate import (
    compile_ahead, locate, locate_batch, method_options, METHODS,
)
from blob_tracker.location.locator import Locator
from blob_tracker.location.phase_correction import (
    correct_phase,
    learn_phase_correction,
    PhaseCorrection,
)

__all__ = [
    'EffectivePsf', 'Estimates', 'Learned', 'Locator', 'METHODS', 'PhaseCorrection',
    'compile_ahead', 'correct_phase', 'learn_phase_correction', 'learn_pulse', 'locate',
    'locate_batch', 'method_options',
]
