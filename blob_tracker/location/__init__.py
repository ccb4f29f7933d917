"""Window -> Location: where in the picture the blob is, far below a pixel."""

from blob_tracker.location.estimates import Estimates
from blob_tracker.location.locate import compile_ahead, locate, locate_batch, METHODS

__all__ = ['Estimates', 'METHODS', 'compile_ahead', 'locate', 'locate_batch']
