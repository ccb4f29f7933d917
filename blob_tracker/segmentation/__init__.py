"""Frame ... -> Window: find the flash, and cut out the pixels that hold it."""

from blob_tracker.segmentation.segmenter import FrameError, Segmenter

__all__ = ['FrameError', 'Segmenter']
