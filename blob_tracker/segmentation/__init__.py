"""Frame ... -> Window: find the flash, and cut out the pixels that hold it."""

from blob_tracker.segmentation.segmenter import FrameError, Segmenter
from blob_tracker.segmentation.sigma_window import compile_ahead
from blob_tracker.segmentation.thresholds import threshold_by_name, THRESHOLDS

__all__ = ['FrameError', 'Segmenter', 'THRESHOLDS', 'compile_ahead', 'threshold_by_name']
