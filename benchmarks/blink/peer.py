"""
The figures of AMI, the tracker of the UVDAR system, tuned to each speed.

Lakemann et al., Robotics and Autonomous Systems (2025), arXiv 2502.01172. Measured with its own
code on frames drawn as those here are (752 x 480 px, 60 frames a second, exposed for half of the
frame, sigma 1.5 px, 100 DN over 20, noise 1 DN, 3 lights, 10 bits): the share of lit frames with
the right name within 2 px of the light, after three lengths of the code.
"""

from __future__ import annotations

from math import nan

SPEEDS = (0.0, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0)  # px a frame at the top
_SMOOTH = {
    'in step': (100.0, 100.0, 99.0, 100.0, 99.0, 97.0, 45.0),
    'free': (71.0, 73.0, 72.0, 72.0, 72.0, 70.0, 35.0),
    'waves': (100.0, 99.0, 98.0, 99.0, 97.0, 94.0, 9.0),
}
_TURNS = {'in step': (nan, 100.0, 100.0, 100.0, 77.0, 57.0, 0.0)}


def found(timing: str, speed: float, turns: bool, lights: int, bits: int, clutter: int) -> float:
    """Return what AMI finds, %; NaN where it was not measured."""
    table = _TURNS if turns else _SMOOTH
    if speed not in SPEEDS or lights != 3 or bits != 10 or clutter or timing not in table:
        return nan
    return table[timing][SPEEDS.index(speed)]
