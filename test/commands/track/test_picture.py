"""The picture of a track: the scatter that it shows is that of the covariances."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.commands.track.outcome import Outcome, Summary, Trail
from blob_tracker.commands.track.picture import draw_track, normalised_differences
from blob_tracker.types import Bearing, Frame, Location
import cv2
import numpy as np
import pytest

COUNT = 800
INTERVAL_NS = 33_333_333
COVARIANCE = np.array([[4e-4, 1e-4], [1e-4, 1e-4]])


def walk(seed: int = 5) -> Trail:
    """Return a light on a smooth path, placed with the noise of its covariance, with a gap."""
    generator = np.random.default_rng(seed)
    seconds = np.arange(COUNT) / 30.0
    places = np.stack([100.0 * np.sin(0.5 * seconds), 50.0 * np.cos(0.3 * seconds)], axis=1)
    places += generator.multivariate_normal(np.zeros(2), COVARIANCE, COUNT)
    stamps = INTERVAL_NS * np.arange(COUNT)
    stamps[COUNT // 2:] += 10**10
    return Trail(stamps.tolist(), [tuple(each) for each in places], [COVARIANCE] * COUNT)


def test_differences_are_standard_normal_where_the_sigmas_are_true() -> None:
    """None of them reaches across the gap."""
    values = normalised_differences(walk())
    assert values.size == 2 * (COUNT - 2 * 4)
    # Of N differences that share their places: see `scatter`, 2.63 for 1.
    assert values.std() == pytest.approx(1.0, abs=3.0 * np.sqrt(2.63 / 2.0 / values.size))
    assert np.abs(values).max() < 6.0
    assert normalised_differences(Trail([0], [(0.0, 0.0)], [COVARIANCE])).size == 0


@pytest.mark.parametrize('angles', [True, False])
def test_it_is_drawn_with_one_place_too(tmp_path: Path, angles: bool) -> None:
    """In angles, or in px; two lights, one of them seen once."""
    summary = Summary(angles)
    frame = Frame(np.zeros((48, 64), np.uint8), 0, 255)
    location = Location(3.0, 4.0, COVARIANCE, 100.0, 10.0, 1.5, 50.0, 1.0, 0)
    summary.frames = [0, INTERVAL_NS]
    summary.add(Outcome('0', frame, 'port', location, Bearing(1.0, 2.0, COVARIANCE)))
    summary.add(Outcome('1', frame, reason='dark'))
    summary.trails['starboard'] = walk()
    assert summary.placed == COUNT + 1 and summary.reasons.most() == [('dark', 1)]
    assert summary.trails['port'].places == [(1.0, 2.0) if angles else (3.0, 4.0)]
    draw_track(tmp_path / 't.png', summary, (64, 48))
    assert cv2.imread(str(tmp_path / 't.png')) is not None
