"""Lights that blink, followed from frame to frame: points in, names and times out. No pixels."""

from blob_tracker.blinking.patterns import code, Pattern, wave
from blob_tracker.blinking.tracker import BlinkTracker, Lit

__all__ = ['BlinkTracker', 'Lit', 'Pattern', 'code', 'wave']
