"""What passes covers what is behind it and comes round."""

from blob_tracker.simulation import PassingObject, Scene
import numpy as np
import pytest


def drawn(thing: PassingObject, index: int) -> np.ndarray:
    """Return a picture of 40 DN, 120 x 90 px, with it in."""
    picture = np.full((90, 120), 40.0, dtype=np.float32)
    thing.draw(picture, Scene().shot(index))
    return picture


@pytest.mark.parametrize('index', [0, 7])
def test_it_covers_its_area_at_its_place(index: int) -> None:
    """Soft edges keep the area, and its middle is where its speed has brought it."""
    thing = PassingObject(30.3, 50.6, 20.0, 9.0, 100.0, speed_x=2.5, speed_y=-1.5)
    cover = (drawn(thing, index) - 40.0) / 60.0
    y, x = np.mgrid[:90, :120]
    assert cover.max() == pytest.approx(1.0, abs=1e-3)
    assert cover.sum() == pytest.approx(180.0, rel=1e-3)
    assert (cover * x).sum() / cover.sum() == pytest.approx(30.3 + 2.5 * index, abs=1e-2)
    assert (cover * y).sum() / cover.sum() == pytest.approx(50.6 - 1.5 * index, abs=1e-2)


def test_it_leaves_and_comes_in_again() -> None:
    """Out of sight for a while, at most twice its size and the margins, and then back."""
    thing = PassingObject(60.0, 45.0, 20.0, 10.0, 0.0, speed_x=-4.0)
    seen = np.array([bool((drawn(thing, index) < 39.0).any()) for index in range(200)])
    assert seen[0] and not seen.all()
    hidden = np.flatnonzero(~seen)
    assert 5 <= np.flatnonzero(np.diff(hidden) > 1)[0] + 1 <= 15
    assert seen[hidden[0] + 20]
