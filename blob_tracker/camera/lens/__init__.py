"""The lens models that camera_info knows, one file for each."""

from dataclasses import replace

from blob_tracker.camera.lens import (
    double_sphere, equidistant, eucm, ocamcalib, plumb_bob, rational_polynomial,
)
from blob_tracker.camera.lens.definition import Lens, LensError

# ROS' name of the distortion model: what it computes. To add one: a file and a line.
LENSES = {
    '': replace(plumb_bob.LENS, counts=(0,), names=()),  # camera_info without distortion
    'plumb_bob': plumb_bob.LENS,
    'rational_polynomial': rational_polynomial.LENS,
    'equidistant': equidistant.LENS,
    'double_sphere': double_sphere.LENS,
    'eucm': eucm.LENS,
    'ocamcalib': ocamcalib.LENS,
}


def todays_name(distortion_model: str) -> str:
    """Return the name in `LENSES` of what some releases of ROS call otherwise."""
    return next(
        (name for name, lens in LENSES.items() if distortion_model in lens.former_names),
        distortion_model,
    )


__all__ = ['Lens', 'LensError', 'LENSES', 'todays_name']
