"""Points are linked to the lights that they are of, in motion and through dark frames."""

from __future__ import annotations

from blob_tracker.blinking.paths import MOST_PATHS, PathLinker
import numpy as np
import pytest

INTERVAL = 1 / 60


def point(x: float, y: float, flux: float = 1000.0) -> list[float]:
    """Return a point that is known to 0.05 px."""
    return [x, y, 0.0025, 0.0, 0.0025, flux, 10.0]


def table(rows: list[list[float]]) -> np.ndarray:
    """Return points as an array, also where there are none."""
    return np.array(rows).reshape(-1, 7)


@pytest.mark.parametrize('speed', [0.0, 2.0, 5.0])
def test_each_light_has_one_path(speed: float) -> None:
    """Six lights on ellipses, each on for 3 frames in 7 at another phase, and still lamps."""
    linker, owners = PathLinker(INTERVAL), []
    for k in range(150):
        rows, own = [], []
        for light in range(6):
            if (k + light) % 7 < 3:
                turn = speed / 90.0 * k + light
                rows.append(point(
                    120.0 + 100.0 * (light % 3) + 90.0 * np.cos(turn) / (1 + light % 2),
                    120.0 + 200.0 * (light // 3) + 90.0 * np.sin(turn),
                ))
                own.append(light)
        rows += [point(10.0, 10.0), point(700.0, 30.0)]
        own += [6, 7]
        linker.update(table(rows), float(k))
        owners.append(own)
    paths = linker.paths(20)
    assert len(paths) == 8
    seen = []
    for path in paths:
        names = [owners[frame][index] for frame, index in zip(path.frames, path.points)]
        most = max(set(names), key=names.count)
        # Where two paths cross a point may go to the other one.
        assert names.count(most) > 0.95 * len(names)
        seen.append(most)
    assert sorted(seen) == list(range(8))


def test_a_path_ends_after_long_darkness() -> None:
    """What comes after more than a second is another one."""
    linker = PathLinker(INTERVAL)
    for k in (*range(10), *range(90, 100)):
        linker.update(table([point(50.0, 50.0)]), float(k))
    assert [len(path.frames) for path in linker.paths(1)] == [10, 10]


def test_paths_in_a_crowd_are_bounded() -> None:
    """500 points, most of which find no row."""
    random = np.random.default_rng(1)
    linker = PathLinker(INTERVAL)
    places = random.uniform(0.0, 700.0, (500, 2))
    for k in range(30):
        rows = [point(x, y) for x, y in places if random.uniform() < 0.7]
        linker.update(table(rows), float(k))
    paths = linker.paths(2)
    assert sum(len(path.frames) for path in paths) <= 30 * MOST_PATHS


def test_nothing_is_no_path() -> None:
    """Frames without a point, and none at all."""
    linker = PathLinker(INTERVAL)
    assert linker.paths(1) == []
    linker.update(table([]), 0.0)
    assert linker.paths(1) == []
