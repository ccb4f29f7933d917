"""After `compile_ahead` no bearing waits for a compiler."""

from __future__ import annotations

from blob_tracker.constellation.compilation import compile_ahead
from blob_tracker.constellation.pose import poses
from blob_tracker.kernel import compiled
import pytest


def test_the_loops_are_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its bearings have one pose, so that all of the fit has run."""
    found = []
    monkeypatch.setattr(
        'blob_tracker.constellation.compilation.poses',
        lambda *arguments: found.extend(poses(*arguments)),
    )
    compile_ahead()
    assert len(found) == 1
    done, count, _ = compiled('blob_tracker.constellation')
    assert done == count
