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
    """
    Give the fields that came, in the order of the film, with their pictures' numbers and kinds.

    The stamps are the camera's: on an emulated processor the player's tell how late it was.
    """
    camera = analogue_camera()
    film = [
        field for index in range(ANALOGUE_PICTURES)
        for field in fields(camera.picture(index), camera.order, camera.interval_ns)
    ]
    found: Any = np.load(results / 'analogue.npz')
    assert str(found['words']) == 'top before bottom, line by line'
    came = []
    for at in np.argsort(found['numbers']):
        number, image = int(found['numbers'][at]), found['images'][at]
        # The driver writes a signal for television sets into the first line.
        np.testing.assert_array_equal(image[1:], film[number].image[1:])
        field = Frame(
            image, film[number].stamp_ns, 255, y0=int(found['y0'][at]), binning=(1, 2))
        came.append((field, divmod(number, 2)))
    return came


def test_fields_arrive_as_they_were_played(seen):
    assert len(seen) == 2 * ANALOGUE_PICTURES  # the guest waited for each
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
    assert len(kinds) >= 16 and set(kinds) == {0, 1}  # of 24 lit fields, once it is believed
