"""Track a flashing light to a fraction of a pixel and give its angle, with a true covariance."""

from importlib import import_module
from typing import Any, TYPE_CHECKING

if TYPE_CHECKING:
    from blob_tracker.camera import CameraModel
    from blob_tracker.pipeline import Pipeline
    from blob_tracker.types import Bearing, Frame, Location, SensorNoise, Window

__all__ = [
    'Bearing',
    'CameraModel',
    'Frame',
    'Location',
    'Pipeline',
    'SensorNoise',
    'Window',
]
_ROOMS = {'CameraModel': 'blob_tracker.camera', 'Pipeline': 'blob_tracker.pipeline'}


def __getattr__(name: str) -> Any:
    """Import a name when it is first used: a camera node need not load the fits."""
    if name not in __all__:
        raise AttributeError(f"module 'blob_tracker' has no attribute '{name}'")
    return getattr(import_module(_ROOMS.get(name, 'blob_tracker.types')), name)
