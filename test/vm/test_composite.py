"""An analogue camera's light through the driver's S-Video: what guest_composite.py wrote down."""

from __future__ import annotations

from typing import Any

from blob_tracker.camera import CameraModel, pinhole_matrix
from blob_tracker.capture.fields import fields
from blob_tracker.pipeline import Pipeline
from blob_tracker.types import Frame
import numpy as np
import pytest
from vm.scene import (
    analogue_camera, ANALOGUE_HEIGHT, ANALOGUE_PICTURES, ANALOGUE_WIDTH, NOISE,
)

pytestmark = pytest.mark.timeout(60, func_only=True)  # the boot is watched by itself
MODEL = CameraModel(
    ANALOGUE_WIDTH, ANALOGUE_HEIGHT, pinhole_matrix(700.0, ANALOGUE_WIDTH, ANALOGUE_HEIGHT))


@pytest.fixture(scope='module')
def seen(results) -> list[tuple[Frame, tuple[int, int]]]:
    """Give the fields that came, each with the number of its picture and its kind."""
    camera = analogue_camera()
    # The driver writes a signal for television sets into the first line.
    known = {
        field.image[1:].tobytes(): (index, field.y0)
        for index in range(ANALOGUE_PICTURES)
        for field in fields(camera.picture(index), camera.order, camera.interval_ns)
    }
    found: Any = np.load(results / 'analogue.npz')
    assert str(found['words']) == 'top before bottom, line by line'
    came = []
    for image, stamp, y0 in zip(found['images'], found['stamps'], found['y0']):
        shown = known.get(image[1:].tobytes())
        if shown is not None:  # not the driver's own picture
            came.append((Frame(image, int(stamp), 255, y0=int(y0), binning=(1, 2)), shown))
    return came


def test_fields_arrive_as_they_were_played(seen):
    assert len(seen) >= 20
    assert {field.y0 for field, _ in seen} == {0, 1}
    assert all(field.y0 == kind for field, (_, kind) in seen)


def test_the_bearings_of_both_fields_are_right(seen):
    camera, pipeline = analogue_camera(), Pipeline(MODEL, noise=NOISE)
    kinds = []
    for field, (index, kind) in seen:
        for bearing in pipeline.run([field]):
            later = (kind == 1) * 0.5 * camera.interval_ns
            truth = camera.scene.target.spot((index * camera.interval_ns + later) / 1e9)
            x, y, by_angles = MODEL.place(bearing.azimuth, bearing.elevation)
            error = np.array([x - truth.x, y - truth.y])
            covariance = by_angles @ bearing.covariance @ by_angles.T
            # Half a line would be 0.5 px, a field's way 3 px. Five sigma, and what it moves while
            # it is exposed.
            assert error @ np.linalg.solve(covariance, error) < 25.0
            assert np.hypot(*error) < 0.3
            kinds.append(kind)
    assert len(kinds) >= 4 and set(kinds) == {0, 1}
