"""Lights that blink, followed from frame to frame: points in, names and times out. No pixels."""
