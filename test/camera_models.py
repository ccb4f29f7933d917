"""Calibrated cameras for the tests: an ideal lens, both distortion models, and a skew."""

import dataclasses

from blob_tracker.camera import CameraModel, pinhole_matrix
import numpy as np

PINHOLE = CameraModel(640, 480, pinhole_matrix(600.0, 640, 480))
PLUMB_BOB = dataclasses.replace(
    PINHOLE, distortion=np.array([-0.28, 0.09, 0.001, -0.0005, -0.01])
)
RATIONAL = dataclasses.replace(
    PINHOLE,
    distortion=np.array([0.4, 0.1, 0.001, -0.0005, 0.01, 0.7, 0.2, 0.02]),
    distortion_model='rational_polynomial',
)
SKEWED = dataclasses.replace(
    PLUMB_BOB, matrix=np.array([[610.0, 1.5, 300.0], [0.0, 590.0, 250.0], [0.0, 0.0, 1.0]])
)
MODELS = {'pinhole': PINHOLE, 'plumb_bob': PLUMB_BOB, 'rational': RATIONAL, 'skewed': SKEWED}
