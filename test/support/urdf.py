"""What robot_state_publisher makes of a URDF and of joint states."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from blob_tracker.transforms import Transform
import numpy as np
from scipy.spatial.transform import Rotation


class Joint(NamedTuple):
    """A joint: where its child's origin is in the parent, and about what it turns."""

    name: str
    kind: str
    parent: str
    child: str
    place: list[float]
    turn: Rotation
    axis: list[float]
    limits: tuple[float, float]

    def at(self, angle: float) -> Transform:
        """Return how the child lies in the parent."""
        turn = self.turn * Rotation.from_rotvec(angle * np.array(self.axis))
        x, y, z = self.place
        return Transform((x, y, z), tuple(turn.as_quat().tolist()))


def read_urdf(path: Path) -> tuple[list[str], list[Joint]]:
    """Return the names of the links, and the joints."""
    robot = ElementTree.parse(path).getroot()
    assert robot.tag == 'robot'
    joints = []
    for each in robot.findall('joint'):
        origin, axis, limit = each.find('origin'), each.find('axis'), each.find('limit')
        joints.append(Joint(
            each.attrib['name'], each.attrib['type'], each.find('parent').attrib['link'],
            each.find('child').attrib['link'], _numbers(origin.attrib['xyz']),
            Rotation.from_euler('xyz', _numbers(origin.attrib['rpy'])),
            [1.0, 0.0, 0.0] if axis is None else _numbers(axis.attrib['xyz']),
            (0.0, 0.0) if limit is None else (
                float(limit.attrib['lower']), float(limit.attrib['upper'])),
        ))
    return [link.attrib['name'] for link in robot.findall('link')], joints


def frames(
    joints: list[Joint], angles: Mapping[str, float], *, fixed: bool
) -> dict[str, tuple[str, Transform]]:
    """Return each child with its parent and how it lies there, of the joints of one kind."""
    return {
        joint.child: (joint.parent, joint.at(angles.get(joint.name, 0.0)))
        for joint in joints if (joint.kind == 'fixed') is fixed
    }


def _numbers(text: str) -> list[float]:
    return [float(word) for word in text.split()]
