"""camera/image_raw -> target/window: find the flash and cut it out, lit and unlit."""

from blob_tracker.nodes.interface.segmenter import PARAMETERS
from blob_tracker.nodes.segmenter.node import compile_search, main, SegmenterNode

__all__ = ['compile_search', 'main', 'PARAMETERS', 'SegmenterNode']
