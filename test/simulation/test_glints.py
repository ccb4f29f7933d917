"""Glints are short, in their region, and as many as said."""

from blob_tracker.simulation import Glints, Scene
import numpy as np
import pytest

SCENE = Scene(width=320, height=240)


def drawn(glints: Glints, index: int) -> np.ndarray:
    """Return what they add to a picture of 320 x 240 px."""
    picture = np.zeros((240, 320), dtype=np.float32)
    glints.draw(picture, SCENE.shot(index))
    return picture


def test_each_lasts_one_to_three_frames() -> None:
    """Where one pixel is bright it is dark again three frames later, but for chance."""
    glints = Glints(rate=0.02, size=0.0, amplitude=100.0, streaks=0.0, seed=3)
    lit = np.array([drawn(glints, index).max() > 1.0 for index in range(3000)])
    edges = np.flatnonzero(np.diff(np.concatenate([[0], lit.astype(int), [0]])))
    lengths = edges[1::2] - edges[::2]
    assert set(lengths) >= {1, 2, 3}
    # Two in a row, one after the other, are 1 in 20.
    assert (lengths <= 3).mean() > 0.85


def test_their_number_and_brightness_are_those_asked_for() -> None:
    """The mean of all they add: groups, glints of each, frames of each, light of each."""
    glints = Glints(rate=0.4, size=3.0, amplitude=60.0, streaks=0.0, spread=3.0, seed=1)
    total = np.mean([drawn(glints, index).sum() for index in range(3, 3003)])
    # A width uniform from 0.5 to 1.6 px has the mean square 1.2033 px^2; a life is 2 frames.
    # Those near the border lose a per cent, and 5,000 exponential peaks are good to 3 %.
    expected = 0.4 * 4.0 * 2.0 * 60.0 * 2.0 * np.pi * 1.2033
    assert total == pytest.approx(expected, rel=0.1)


def test_they_stay_in_their_region() -> None:
    """Groups have their middle in the lowest fifth; they reach out of it a little."""
    glints = Glints(rate=1.0, spread=3.0, streaks=0.0, region=(0.0, 0.8, 1.0, 1.0))
    total = np.sum([drawn(glints, index) for index in range(300)], axis=0)
    assert total[:150].max() < 1e-3 < total[200:].max()


def test_streaks_are_long() -> None:
    """Three to eight times as long as wide."""
    glints = Glints(rate=0.05, size=0.0, streaks=1.0, region=(0.3, 0.3, 0.7, 0.7), seed=2)
    y, x = np.mgrid[:240, :320]
    ratios = []
    for index in range(200):
        picture = drawn(glints, index).astype(float)
        if picture.max() > 1.0:
            total = picture.sum()
            apart = np.stack([each - (picture * each).sum() / total for each in (x, y)])
            spread = np.einsum('ihw,jhw,hw->ij', apart, apart, picture) / total
            least, greatest = np.linalg.eigvalsh(spread)
            ratios.append(np.sqrt(greatest / least))
    assert len(ratios) > 5
    # Sampling in the pixels' middles widens the narrow axis of the finest by some per cent.
    assert np.median(ratios) > 3.0
