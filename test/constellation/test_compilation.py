"""After `compile_ahead` no bearing waits for a compiler."""

from __future__ import annotations

from typing import Any

from blob_tracker.constellation import candidates, likelihood
from blob_tracker.constellation.compilation import compile_ahead
from blob_tracker.constellation.pose import poses
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
    loops: tuple[Any, ...] = (candidates.candidates, likelihood.fit)
    assert all(loop.signatures for loop in loops)
