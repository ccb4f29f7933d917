"""What came of each frame, one after the other, and what can be said of all of them."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

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
        px; None where there is none.
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
class Path:
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
        """Return the scatter of the places over their sigmas; None where there are too few."""
        if not self.stamps:
            return None
        return scatter(
            np.array(self.stamps, dtype=np.int64), np.array(self.places),
            np.array(self.covariances),
        )


class Summary:
    """
    All outcomes together.

    Attributes
    ----------
    angles : bool
        Whether the places are angles, mrad; else they are px.
    frames : list of int
        Stamps of the frames, ns.
    paths : dict of str to Path
        By the name of the light.
    reasons : Counter
        Why there was no location, with the number of frames.

    """

    def __init__(self, angles: bool) -> None:
        self.angles = angles
        self.frames: list[int] = []
        self.paths: dict[str, Path] = {}
        self.reasons: Counter[str] = Counter()

    @property
    def placed(self) -> int:
        """Return how many places there are, of all lights."""
        return sum(len(path.stamps) for path in self.paths.values())

    def add(self, outcome: Outcome) -> None:
        """Take what came of a frame."""
        location, bearing = outcome.location, outcome.bearing
        if location is None:
            self.reasons[outcome.reason] += 1
            return
        path = self.paths.setdefault(outcome.light, Path())
        path.stamps.append(location.stamp_ns)
        if self.angles and bearing is not None:
            path.places.append((bearing.azimuth, bearing.elevation))
            path.covariances.append(bearing.covariance)
        else:
            path.places.append((location.x, location.y))
            path.covariances.append(location.covariance)
