"""Frame ... -> Window: find the flash, and cut out the pixels that hold it."""

from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.compiled import compile_ahead
from blob_tracker.segmentation.detections import Detections
from blob_tracker.segmentation.expectation import Expectation
from blob_tracker.segmentation.exposure import exposure_fault
from blob_tracker.segmentation.field_segmenter import FieldSegmenter
from blob_tracker.segmentation.flash import Flash
from blob_tracker.segmentation.flash_modes import flash_by_name, FLASH_MODES
from blob_tracker.segmentation.history import FrameError
from blob_tracker.segmentation.registration import REGISTRATIONS
from blob_tracker.segmentation.segmenter import Segmenter, Sighting
from blob_tracker.segmentation.thresholds import threshold_by_name, THRESHOLDS

__all__ = [
    'Candidate',
    'Detections',
    'Expectation',
    'FLASH_MODES',
    'FieldSegmenter',
    'Flash',
    'FrameError',
    'REGISTRATIONS',
    'Segmenter',
    'Sighting',
    'THRESHOLDS',
    'compile_ahead',
    'exposure_fault',
    'flash_by_name',
    'threshold_by_name',
]
