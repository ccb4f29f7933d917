"""What the room refuses, and says why."""

from __future__ import annotations


class ConstellationError(ValueError):
    """A body, or bearings of its lights, that give no pose; the message says why."""


class BodyError(ConstellationError):
    """A body whose lights cannot be what its file says."""


class TooFewLights(ConstellationError):
    """Fewer lights than a pose needs, or in one line."""


class Inconsistent(ConstellationError):
    """Bearings that no pose of the body explains."""
