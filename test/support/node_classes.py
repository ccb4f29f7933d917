"""Every node of the package but the pipeline, which is several: its class, and what opens it."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from blob_tracker.nodes import NODES
from rclpy.node import Node

CLASSES: dict[str, type[Node]] = {
    name: getattr(import_module(f'blob_tracker.nodes.{name}'), f'{name.title()}Node')
    for name in NODES if name != 'pipeline'
}
# What has a node take and give all that it can, where that is more than at its start.
OPENED: dict[str, dict[str, Any]] = {
    'locator': {'noise.online': True, 'range.psf_sigma': 1.2, 'range.diameter': 0.05},
    'segmenter': {'noise.measure': True, 'follow_prediction': True},
    'tracker': {'imu.enabled': True, 'imu.use_tf': True, 'joints.pan': 'pan'},
    'triangulator': {'use_tf': True},
    'constellation': {'publish_tf': True},
    'simulator': {'pan_tilt': True},
}
# What a change opens besides: at the start it would be in place of another.
CHANGED: dict[str, dict[str, Any]] = {'segmenter': {'image_transport': 'compressed'}}
