"""The controls of an open device, and of the sensor and subdevices that feed it."""

from __future__ import annotations

from collections.abc import Callable
import errno
from functools import partial
import os
import threading
from typing import TypeVar

from blob_tracker.capture import controls, videodev2
from blob_tracker.capture.controls import Control, ControlError, Ioctl
from blob_tracker.capture.errors import CaptureError
from blob_tracker.capture.refusals import unplugged
from blob_tracker.capture.sensor import ControlRoute, of_video_device

Result = TypeVar('Result')


class DeviceControls:
    """
    Get and set controls while another thread may close the device.

    Parameters
    ----------
    device : str
        What to call it.
    call : function
        As that of `controls.controls`, of the device alone.

    Attributes
    ----------
    call : function
        The same, of the device or the subdevice that has the control.
    sensor : str
        Name and subdevices of the sensor behind a media controller; '' without one.
    lock : Lock
        Held by whom the device must not be closed under.
    closed : bool
        Whether the device is closed.

    """

    def __init__(self, device: str, call: Ioctl) -> None:
        self.call = call
        self.sensor = ''
        self.lock = threading.Lock()
        self.closed = False
        self._device = device
        self._silent: dict[int, int] = {}  # controls that do not answer
        self._subdevices: tuple[int, ...] = ()

    def find_sensor(self, fd: int) -> None:
        """
        Open the subdevices that feed the device, for their controls.

        Parameters
        ----------
        fd : int
            The device, open.

        """
        found = of_video_device(fd)
        if found is None:
            return
        sensor, paths = found
        refused = []
        for path in paths:
            try:
                own = os.open(path, os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
                self._subdevices += (own,)
            except OSError as error:
                refused.append(f'{path} cannot be opened for its controls: {error.strerror}')
        self.sensor = '; '.join([f'{sensor.name} ({", ".join(paths)})', *refused])
        self.call = ControlRoute(
            [self.call, *(partial(videodev2.ioctl, each) for each in self._subdevices)])

    def found(self) -> dict[str, Control]:
        """
        Return the controls as the drivers have them now: name -> control.

        Raises
        ------
        OSError
            The device fails.

        """
        return controls.controls(self.call, self._silent)

    def named(self, name: str | Control) -> Control:
        """Return a control by its name; one that was found is not looked up again."""
        if isinstance(name, Control):
            return name
        found = self.found()
        if name not in found:
            there_are = ', '.join(sorted(found)) or 'none'
            raise ControlError(
                f"there is no control '{name}'; the controls of {self._device} are {there_are}")
        return found[name]

    def guarded(self, action: Callable[[], Result]) -> Result:
        """
        Do something with controls while the device cannot be closed by another thread.

        Raises
        ------
        CaptureError
            The device is gone, fails, or is closed.

        """
        with self.lock:
            self.check_open()
            try:
                return action()
            except OSError as error:
                if error.errno == errno.ENODEV:
                    raise CaptureError(unplugged(self._device)) from error
                raise CaptureError(
                    f'{self._device}: its controls cannot be queried: {error.strerror}') from error

    def check_open(self) -> None:
        """Raise CaptureError if the device is closed."""
        if self.closed:
            raise CaptureError(f'{self._device}: the camera is closed; open it again')

    def close(self) -> None:
        """Close the subdevices; the caller holds the lock."""
        self.closed = True
        for fd in self._subdevices:
            os.close(fd)
        self._subdevices = ()
