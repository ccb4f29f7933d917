"""Pixel to ray and back."""

from blob_tracker.camera.lens import project, unproject
from camera_models import MODELS
import numpy as np
import pytest


@pytest.mark.parametrize('name', MODELS)
def test_round_trip_is_exact(name: str) -> None:
    """Pixel -> ray -> pixel comes back below 1e-9 px, all over the image."""
    model = MODELS[name]
    for x in np.linspace(0, 639, 7):
        for y in np.linspace(0, 479, 7):
            pixel = np.array([x, y])
            ray, _ = unproject(pixel, model.matrix, model.distortion)
            back, _ = project(ray, model.matrix, model.distortion)
            np.testing.assert_allclose(back, pixel, rtol=0, atol=1e-9)
