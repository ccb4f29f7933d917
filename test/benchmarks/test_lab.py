"""The lab's speed is that of its default scene, and its target can be missed."""

from __future__ import annotations

from benchmarks import lab
from benchmarks.lab import DEFAULT, Row
from benchmarks.report import Report
from benchmarks.targets import judge
import numpy as np


def test_all_scenes_are_drawn_with_half_of_their_frames_lit() -> None:
    """Each shows its light in the frame in which it is."""
    for name, scene in lab.scenes().items():
        truth = scene.truth(0)
        assert truth.lit and not scene.truth(1).lit
        column, row = round(truth.x), round(truth.y)
        lit, unlit = (scene.frame(index)[row, column].astype(float) for index in (0, 1))
        assert lit - unlit > 100.0, name


def test_the_target_is_that_of_the_default_scene() -> None:
    """Others are for information."""
    for rate, met in ((201.0, True), (199.0, False)):
        target, = judge(Report(lab=[Row(DEFAULT, rate), Row('other', np.nan)]), [])
        assert target.met is met
