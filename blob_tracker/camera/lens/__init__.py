"""The lens models that camera_info knows, one file for each."""

from blob_tracker.camera.lens import equidistant, rational_polynomial
from blob_tracker.camera.lens.definition import Lens, LensError

# ROS' name of the distortion model: what it computes. To add one: a file and a line.
LENSES = {
    '': Lens((0,), rational_polynomial.image, rational_polynomial.ray),
    'plumb_bob': Lens((0, 4, 5), rational_polynomial.image, rational_polynomial.ray),
    'rational_polynomial': Lens(
        (0, 8, 12, 14), rational_polynomial.image, rational_polynomial.ray
    ),
    'equidistant': Lens((0, 4), equidistant.image, equidistant.ray),
}
# What some releases of ROS' own calibrator write: today's name.
FORMER_NAMES = {'fisheye': 'equidistant'}

__all__ = ['FORMER_NAMES', 'Lens', 'LensError', 'LENSES']
