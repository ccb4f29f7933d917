"""target/ray -> target/bearing_predicted, target/track and target/tracked."""

from blob_tracker.nodes.interface.tracker import PARAMETERS
from blob_tracker.nodes.tracker.node import compile_filter, main, TrackerNode

__all__ = ['compile_filter', 'main', 'PARAMETERS', 'TrackerNode']
