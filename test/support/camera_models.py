"""Calibrated cameras for the tests: an ideal lens, each distortion model, and a skew."""

import dataclasses

from blob_tracker.camera import CameraModel, pinhole_matrix
import cv2
import numpy as np
from numpy.typing import NDArray

PINHOLE = CameraModel(640, 480, pinhole_matrix(600.0, 640, 480))
PLUMB_BOB = dataclasses.replace(
    PINHOLE, distortion=np.array([-0.28, 0.09, 0.001, -0.0005, -0.01])
)
RATIONAL = dataclasses.replace(
    PINHOLE,
    distortion=np.array([0.4, 0.1, 0.001, -0.0005, 0.01, 0.7, 0.2, 0.02]),
    distortion_model='rational_polynomial',
)
# A wide lens with the prism of a sensor that is not square to it, and that sensor tilted by 2 and
# 3 degrees.
PRISM = dataclasses.replace(
    PINHOLE,
    matrix=pinhole_matrix(330.0, 640, 480),
    distortion=np.array([
        0.4, 0.1, 0.001, -0.0005, 0.01, 0.75, 0.25, 0.02, 0.002, -0.001, -0.003, 0.0005,
    ]),
    distortion_model='rational_polynomial',
)
TILTED = dataclasses.replace(PRISM, distortion=np.append(PRISM.distortion, [0.035, -0.052]))
SKEWED = dataclasses.replace(
    PLUMB_BOB, matrix=np.array([[610.0, 1.5, 300.0], [0.0, 590.0, 250.0], [0.0, 0.0, 1.0]])
)
# 180 degrees across the diagonal of 800 px would be 255 px a radian: here 220 degrees are seen.
EQUIDISTANT = dataclasses.replace(
    PINHOLE,
    matrix=pinhole_matrix(205.0, 640, 480),
    distortion=np.array([0.02, -0.004, 0.001, -0.0002]),
    distortion_model='equidistant',
)
# Those of fish-eyes, as basalt, Kalibr and OCamCalib give them.
DOUBLE_SPHERE = dataclasses.replace(
    PINHOLE, matrix=pinhole_matrix(230.0, 640, 480), distortion=np.array([-0.2, 0.6]),
    distortion_model='double_sphere',
)
EUCM = dataclasses.replace(
    PINHOLE, matrix=pinhole_matrix(230.0, 640, 480), distortion=np.array([0.63, 1.04]),
    distortion_model='eucm',
)
OCAMCALIB = dataclasses.replace(
    PINHOLE, matrix=pinhole_matrix(220.0, 640, 480),
    distortion=np.array([1.0003, -0.0002, 0.0005, 0.0, -0.32, 0.03, -0.04]),
    distortion_model='ocamcalib',
)
MODELS = {
    'pinhole': PINHOLE,
    'plumb_bob': PLUMB_BOB,
    'rational': RATIONAL,
    'prism': PRISM,
    'tilted': TILTED,
    'skewed': SKEWED,
    'equidistant': EQUIDISTANT,
    'double_sphere': DOUBLE_SPHERE,
    'eucm': EUCM,
    'ocamcalib': OCAMCALIB,
}


def opencv_pixels(model: CameraModel, rays: NDArray[np.float64]) -> NDArray[np.float64]:
    """Image rays (N, 3) in front of the camera by OpenCV: (N, 2) px. It leaves out the skew."""
    origin, points = np.zeros(3), rays.reshape(-1, 1, 3)
    image = (
        cv2.fisheye.projectPoints if model.distortion_model == 'equidistant'
        else cv2.projectPoints
    )
    found = image(points, origin, origin, model.matrix, model.distortion)[0]
    return found.reshape(-1, 2).astype(float)


def rays_at(azimuth: NDArray[np.float64], elevation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return unit rays (N, 3) at angles, rad."""
    return np.column_stack([
        np.sin(azimuth) * np.cos(elevation),
        -np.sin(elevation),
        np.cos(azimuth) * np.cos(elevation),
    ])
