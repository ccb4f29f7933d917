"""Lights that blink, followed from frame to frame: points in, names and times out. No pixels."""

from blob_tracker.blinking.patterns import code, Pattern, wave
from blob_tracker.blinking.tracker import BlinkTracker, Known, Lit

__all__ = ['BlinkTracker', 'Known', 'Lit', 'Pattern', 'code', 'wave']
