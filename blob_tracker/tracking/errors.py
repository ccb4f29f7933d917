"""What the room refuses, and says why."""

from __future__ import annotations


class TrackingError(ValueError):
    """A bearing, rate or joint angle that cannot be used; the message says why."""


class StampJump(TrackingError):
    """A stamp from before all that is remembered: the clock was set back, `reset` is due."""


class PlatformGap(LookupError):
    """An instant at which the platform's motion, or the pan/tilt's place, is not known."""


class TriangulationError(TrackingError):
    """Rays that give no position; the message says why."""


class ParallelRays(TriangulationError):
    """Rays that are parallel as far as their covariances can tell."""


class RaysApart(TriangulationError):
    """Rays that meet nowhere, or behind a camera: they are not of one light."""
