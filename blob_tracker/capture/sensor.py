"""The sensor behind a media controller (Raspberry Pi, Jetson, i.MX): its subdevices' controls."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
import errno
import glob
import os
from typing import Any, TypeVar

from blob_tracker.capture import videodev2
from blob_tracker.capture.controls import Ioctl
from blob_tracker.capture.media import read_topology
from blob_tracker.capture.topology import fed_by, Node, Sensor, sensor_of, Topology

Found = TypeVar('Found')


class ControlRoute:
    """
    The controls of several devices as if one device had them all: an `Ioctl`.

    Of a control that several have, the one of the first counts. `controls.controls`,
    `ControlEvents` and `ExposureControls` take it in place of a device.

    Parameters
    ----------
    devices : sequence of Ioctl
        The video device, and then the subdevices in the order of the light.

    """

    def __init__(self, devices: Sequence[Ioctl]) -> None:
        self._devices = list(devices)
        self._owners: dict[int, Ioctl] = {}

    def __call__(self, number: int, argument: Any) -> None:
        """Hand an ioctl of a control to the device that has it."""
        if number == videodev2.QUERY_EXT_CTRL and argument.id & videodev2.CTRL_FLAG_NEXT_CTRL:
            self._next(argument)
        elif number == videodev2.DQEVENT:
            self._event(argument)
        elif number in (videodev2.G_EXT_CTRLS, videodev2.S_EXT_CTRLS):
            self._owner(argument.controls[0].id)(number, argument)
        else:
            self._owner(argument.id)(number, argument)

    def _owner(self, control: int) -> Ioctl:
        return self._owners.get(control, self._devices[0])

    def _next(self, query: videodev2.QueryExtCtrl) -> None:
        """Answer with the control of the next number that any device has."""
        found: list[tuple[int, Ioctl, videodev2.QueryExtCtrl]] = []
        failed: OSError | None = None
        last = query.id & ~videodev2.CTRL_FLAG_NEXT_CTRL
        for device in self._devices:
            answer = videodev2.QueryExtCtrl(id=query.id)
            try:
                device(videodev2.QUERY_EXT_CTRL, answer)
            except OSError as error:
                if error.errno == errno.ENODEV:
                    raise
                if error.errno not in (errno.EINVAL, errno.ENOTTY):
                    failed = error
                continue
            if answer.id > last:  # else a driver that does not know the flag
                found.append((answer.id, device, answer))
        if not found:
            raise failed or OSError(errno.EINVAL, os.strerror(errno.EINVAL))
        number, device, answer = min(found, key=lambda each: each[0])
        self._owners.setdefault(number, device)
        for name, *_ in videodev2.QueryExtCtrl._fields_:
            setattr(query, name, getattr(answer, name))

    def _event(self, event: videodev2.Event) -> None:
        """Take an event of any device."""
        for device in self._devices:
            try:
                device(videodev2.DQEVENT, event)
                return
            except OSError as error:
                last = error
        raise last


def of_video_device(fd: int) -> tuple[Sensor, list[str]] | None:
    """
    Return the sensor that feeds an open video device, and the paths of its subdevices.

    None if there is no media controller, or no subdevice that shows itself: a webcam.
    """
    node = _node(os.fstat(fd).st_rdev)
    sensor = _first(lambda topology: sensor_of(topology, node))
    if sensor is None or not sensor.nodes:
        return None
    return sensor, [_path(each) for each in sensor.nodes]


def of_subdevice(path: str) -> tuple[str, list[str] | None] | None:
    """
    Return the name of a subdevice and the video devices that it feeds; None of any other.

    None for the video devices of one that feeds none, as a lens.
    """
    try:
        node = _node(os.stat(path).st_rdev)
    except OSError:
        return None
    found = _first(lambda topology: fed_by(topology, node))
    if found is None:
        return None
    name, videos = found
    return name, None if videos is None else [_path(each) for each in videos]


def _first(look: Callable[[Topology], Found | None]) -> Found | None:
    """Return what is found in the first media device that has it."""
    return next((found for each in _topologies() if (found := look(each)) is not None), None)


def _topologies() -> Iterator[Topology]:
    """Yield that of each media device of this machine that can be opened."""
    for path in sorted(glob.glob('/dev/media*')):
        try:
            fd = os.open(path, os.O_RDWR | os.O_CLOEXEC)
        except OSError:
            continue
        try:
            yield read_topology(fd)
        except OSError:
            continue
        finally:
            os.close(fd)


def _node(device: int) -> Node:
    return os.major(device), os.minor(device)


def _path(node: Node) -> str:
    """Return the path of a device node."""
    return '/dev/' + os.path.basename(os.path.realpath(f'/sys/dev/char/{node[0]}:{node[1]}'))
