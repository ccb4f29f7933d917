"""Where the triangulator's cameras are: by its parameters, or by TF."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import replace
from typing import Any, NamedTuple

from blob_tracker.nodes.interface.triangulator import ANGLES, AXES, pose_of, pose_parameters
from blob_tracker.ros.diagnostics.health import Health, WARN
from blob_tracker.ros.endpoints.transforms import AGREED_RAD, angle_between, Transforms
from blob_tracker.ros.messages.imu import turn_of
from blob_tracker.ros.parameters.declaration import given
from blob_tracker.tracking import CameraPose
from blob_tracker.transforms import NoTransform, Transform
from blob_tracker.units import MRAD_PER_RAD
import numpy as np
from rclpy.node import Node

# s between two transforms that are interpolated, which a vehicle in its map at 5 Hz needs. Between
# those a pan of 0.3 rad at 0.5 Hz is up to 15 mrad from where the interpolation has it, and nobody
# knows; over longer gaps rays are refused.
HOLD = 0.25
AGREED_M = 0.05  # m by which the places of parameters and of TF may differ: that of a tape


class _Seen(NamedTuple):
    """The last ray of a camera: its frame and its stamp, ns."""

    frame_id: str
    stamp_ns: int


class CameraPlaces:
    """
    Tell where a camera is at the stamp of a ray.

    Parameters
    ----------
    node : Node
        Subscribes to TF, once it is asked for.
    health : Health
        Hears of transforms that cannot be used, and of parameters that say otherwise.
    names : sequence of str
        Of the cameras.
    moved : callable
        Called when transforms have come.

    Attributes
    ----------
    unknown : list of str
        Cameras of which neither parameters nor TF are to say where they are.
    waited : float
        Longest that a ray has waited in this second, s; whoever has it wait counts.

    """

    def __init__(
        self, node: Node, health: Health, names: Sequence[str], moved: Callable[[], None]
    ) -> None:
        self.waited = 0.0
        self.unknown: list[str] = []
        self._names = names
        self._node, self._health, self._moved = node, health, moved
        self._given: dict[str, CameraPose] = {}
        self._by_parameters: set[str] = set()
        self._found: dict[str, tuple[Transform, CameraPose]] = {}
        self._seen: dict[str, _Seen] = {}
        self._frame_id = ''
        self._transforms: Transforms | None = None

    def change(self, values: dict[str, Any]) -> Callable[[], None]:
        """
        Build what these parameters ask for; return what puts it into effect.

        Raises
        ------
        ParameterError
            If TF is asked for, and its messages are not installed.

        """
        poses = {
            name: CameraPose(
                np.array([values[f'{pose_of(name)}.{axis}'] for axis in AXES]),
                turn_of(*(values[f'{pose_of(name)}.{angle}'] for angle in ANGLES)),
                position_sigma=values[f'{pose_of(name)}.position_sigma'],
                rotation_sigma=values[f'{pose_of(name)}.rotation_sigma'],
            )
            for name in self._names
        }
        names = {name for name in self._names if self._is_given(name, values)}
        if values['use_tf'] and self._transforms is None:
            self._transforms = Transforms(
                self._node, self._health, self._moved, nullcontext(), hold=HOLD,
                asked_by='use_tf',
            )

        def use() -> None:
            self._given, self._by_parameters = poses, names
            self.unknown = [
                name for name in self._names if name not in names and not values['use_tf']
            ]
            self._found.clear()
            self._frame_id, self._compares = values['frame_id'], values['use_tf']

        return use

    def is_fixed(self, name: str) -> bool:
        """Tell whether the parameters place a camera, for good."""
        return name in self._by_parameters

    def _is_given(self, name: str, values: dict[str, Any]) -> bool:
        """Tell whether the parameters say where a camera is."""
        ours = {each.name: each.default for each in pose_parameters([name])}
        if any(values[f'{pose_of(name)}.{key}'] != ours[f'{pose_of(name)}.{key}'] for key in (
            *AXES, *ANGLES
        )):
            return True
        # A camera may be at the origin; but a file with all defaults is no word against TF.
        return not values['use_tf'] and bool(given(self._node).keys() & ours.keys())

    def pose(self, name: str, frame_id: str, stamp_ns: int) -> CameraPose:
        """
        Return where a camera is whose rays are in a frame, at a stamp, ns.

        Raises
        ------
        NoTransform
            If TF is to tell and does not: `explain` says why.

        """
        self._seen[name] = _Seen(frame_id, stamp_ns)
        if name in self._by_parameters:
            return self._given[name]
        assert self._transforms is not None
        transform = self._transforms.lookup(frame_id, self._frame_id, stamp_ns).transform
        last = self._found.get(name)
        if last is None or last[0] != transform:
            last = transform, replace(
                self._given[name],
                position=np.array(transform.translation), rotation=transform.matrix,
            )
            self._found[name] = last
        return last[1]

    def explain(self, gap: NoTransform) -> str:
        """Return why a camera's place is not known, and what to do."""
        assert self._transforms is not None
        return self._transforms.explain(gap)

    def last(self) -> dict[str, CameraPose]:
        """Return where the cameras were last, those of which it is known."""
        found = {name: pose for name, (_, pose) in self._found.items()}
        found |= {name: self._given[name] for name in self._by_parameters}
        return {name: found[name] for name in self._names if name in found}

    def forget(self, after_ns: int) -> None:
        """Forget what has a later stamp, ns."""
        if self._transforms is not None:
            self._transforms.forget(after_ns)

    def describe(self) -> None:
        """Show where each place is from, and say where TF has another than the parameters."""
        for name in self._names:
            source = (
                'by parameters' if name in self._by_parameters
                else 'unknown' if name in self.unknown else 'by TF'
            )
            self._health.show(f'place of {name}', source)
            if self._compares and name in self._by_parameters and name in self._seen:
                self._compare(name, *self._seen[name])
        if self._compares:
            self._health.show('longest wait for transforms (ms)', f'{1e3 * self.waited:.1f}')
        self.waited = 0.0

    def _compare(self, name: str, frame_id: str, stamp_ns: int) -> None:
        """Say where TF has another place than the parameters."""
        assert self._transforms is not None
        try:
            found = self._transforms.lookup(frame_id, self._frame_id, stamp_ns).transform
        except NoTransform:
            return  # the parameters do
        given = self._given[name]
        apart_m = float(np.linalg.norm(np.array(found.translation) - given.position))
        apart_rad = angle_between(found.matrix, given.rotation)
        if apart_m > AGREED_M or apart_rad > AGREED_RAD:
            self._health.fault(
                WARN,
                f"the parameters have '{frame_id}' {apart_m:.3f} m and "
                f'{MRAD_PER_RAD * apart_rad:.1f} mrad from where TF has it, and are used: correct '
                f'one of the two, or leave {pose_of(name)}.x ... yaw at their defaults, and TF is '
                'used',
            )
