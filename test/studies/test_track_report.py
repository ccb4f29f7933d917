"""The picture of a track is drawn with and without a truth."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.studies.track_report import draw_track, joined
import cv2
import numpy as np
import pytest


@pytest.mark.parametrize('count', [2, 300])
@pytest.mark.parametrize('known', [True, False])
def test_picture_is_written(known: bool, count: int, tmp_path: Path) -> None:
    """A PNG of readable size, for a simulated and a real camera, for few and many locations."""
    random = np.random.default_rng(4)
    true = random.uniform(20, 300, (count, 2))
    located = true + random.normal(0, 0.01, (count, 2))
    covariances = np.tile(1e-4 * np.eye(2), (count, 1, 1))
    path = tmp_path / 'track.png'
    draw_track(path, located, covariances, true if known else None, (320, 240), 0.05)
    assert cv2.imread(str(path)).shape[1] >= 1000


def test_a_path_is_not_joined_where_frames_are_missing() -> None:
    """A second of 3 px a frame is lost; and a light that rests moves by less than a pixel."""
    x = np.concatenate([np.arange(0.0, 90.0, 3.0), np.arange(270.0, 330.0, 3.0)])
    assert [len(part) for part in joined(np.stack([x, x], axis=1))] == [30, 20]
    resting = np.random.default_rng(2).normal(100.0, 0.05, (50, 2))
    assert len(joined(resting)) == 1
    assert len(joined(resting[:1])) == 1
