"""What came of each frame, one after the other, and what can be said of all of them."""

from __future__ import annotations

from dataclasses import dataclass, field
import re

from blob_tracker.location.scatter import Scatter, scatter
from blob_tracker.types import Bearing, Frame, Location
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Outcome:
    """
    What came of a frame: a light, or the reason why there is none.

    Parameters
    ----------
    name : str
        Of the frame.
    frame : Frame
        The frame.
    light : str
        Name of the light; '' of one without.
    location : Location or None
        px; None if there is none.
    bearing : Bearing or None
        mrad; None of a camera that is not calibrated, too.
    reason : str
        Why there is no location.

    """

    name: str
    frame: Frame
    light: str = ''
    location: Location | None = None
    bearing: Bearing | None = None
    reason: str = ''

    @property
    def stamp_ns(self) -> int:
        """Return when the light was seen, or else the stamp of the frame, ns."""
        return self.frame.stamp_ns if self.location is None else self.location.stamp_ns


@dataclass
class Trail:
    """
    The places of a light, in their order.

    Attributes
    ----------
    stamps : list of int
        ns.
    places, covariances : list
        px and px^2; mrad and mrad^2 of a camera that is calibrated.

    """

    stamps: list[int] = field(default_factory=list)
    places: list[tuple[float, float]] = field(default_factory=list)
    covariances: list[NDArray[np.float64]] = field(default_factory=list)

    def scatter(self) -> Scatter | None:
        """Return the scatter of the places over their sigmas; None if there are too few."""
        if not self.stamps:
            return None
        return scatter(
            np.array(self.stamps, dtype=np.int64), np.array(self.places),
            np.array(self.covariances),
        )


class Sentences:
    """Sentences and how often each was said; the same with other figures is the same."""

    def __init__(self) -> None:
        self._said: dict[str, tuple[str, int]] = {}

    def add(self, sentence: str) -> None:
        """Take one; none if it is empty."""
        if sentence:
            kind = re.sub(r'[\d.]+', '', sentence)
            first, count = self._said.get(kind, (sentence, 0))
            self._said[kind] = first, count + 1

    def most(self) -> list[tuple[str, int]]:
        """Return each as it was said first, the most frequent ahead."""
        return sorted(self._said.values(), key=lambda each: -each[1])


class Summary:
    """
    All outcomes together.

    Attributes
    ----------
    angles : bool
        Whether the places are angles, mrad; else they are px.
    frames : list of int
        Stamps of the frames, ns.
    trails : dict of str to Trail
        By the name of the light.
    reasons : Sentences
        Why there was no location.

    """

    def __init__(self, angles: bool) -> None:
        self.angles = angles
        self.frames: list[int] = []
        self.trails: dict[str, Trail] = {}
        self.reasons = Sentences()

    @property
    def placed(self) -> int:
        """Return how many places there are, of all lights."""
        return sum(len(trail.stamps) for trail in self.trails.values())

    def add(self, outcome: Outcome) -> None:
        """Take what came of a frame."""
        location, bearing = outcome.location, outcome.bearing
        if location is None:
            self.reasons.add(outcome.reason)
            return
        trail = self.trails.setdefault(outcome.light, Trail())
        trail.stamps.append(location.stamp_ns)
        if self.angles and bearing is not None:
            trail.places.append((bearing.azimuth, bearing.elevation))
            trail.covariances.append(bearing.covariance)
        else:
            trail.places.append((location.x, location.y))
            trail.covariances.append(location.covariance)
