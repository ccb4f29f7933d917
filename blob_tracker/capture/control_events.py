"""What other programs, and the driver by itself, change on the controls of an open device."""

from __future__ import annotations

from collections.abc import Iterable
import errno

from blob_tracker.capture import videodev2
from blob_tracker.capture.controls import Control, Ioctl


class ControlEvents:
    """
    The driver's events of its controls.

    Those that the same file descriptor sets itself are left out: they are known.

    Parameters
    ----------
    ioctl : function
        As that of `controls.controls`.
    controls : iterable of Control
        To be listened for.

    Attributes
    ----------
    told : bool
        Whether the driver tells of changes.

    Raises
    ------
    OSError
        ENODEV where the device is gone.

    """

    def __init__(self, ioctl: Ioctl, controls: Iterable[Control]) -> None:
        self.told = False
        self._ioctl = ioctl
        for control in controls:
            if control.kind == 'button':
                continue  # it has no value that could change
            subscription = videodev2.EventSubscription(
                type=videodev2.EVENT_CTRL, id=control.number)
            try:
                ioctl(videodev2.SUBSCRIBE_EVENT, subscription)
                self.told = True
            except OSError as error:
                if error.errno not in (errno.ENOTTY, errno.EINVAL):
                    raise

    def take(self) -> dict[int, int]:
        """Return what changed since the last call: number of the control -> monotonic ns."""
        changed: dict[int, int] = {}
        while self.told:
            event = videodev2.Event()
            try:
                self._ioctl(videodev2.DQEVENT, event)
            except OSError:  # ENOENT: no more; a device that is gone tells so with its frames
                break
            changed[event.id] = event.timestamp.tv_sec * 1_000_000_000 + event.timestamp.tv_nsec
        return changed
