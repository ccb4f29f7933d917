"""<camera>/target/ray of two cameras or more -> target/point and target/pose."""

from blob_tracker.nodes.interface.triangulator import PARAMETERS
from blob_tracker.nodes.triangulator.node import main, TriangulatorNode

__all__ = ['main', 'PARAMETERS', 'TriangulatorNode']
