"""What is known of a simulated frame."""

from __future__ import annotations

from typing import NamedTuple


class Truth(NamedTuple):
    """Where the light is (px) and whether it is on in the frame; NaN where there is none."""

    x: float
    y: float
    lit: bool
