"""The frames of a vehicle: how each lies in its parent, and any in any other at an instant."""

from blob_tracker.transforms.errors import NoTransform, TransformError
from blob_tracker.transforms.transform import Transform
from blob_tracker.transforms.tree import Found, TransformTree

__all__ = ['Found', 'NoTransform', 'Transform', 'TransformError', 'TransformTree']
