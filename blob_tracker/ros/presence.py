"""A process is discovered while it still loads: its participant is there before its nodes."""

from __future__ import annotations

import os
import signal
from types import FrameType

from blob_tracker.resources import config_path
from blob_tracker.ros.diagnostics.shared_memory import VARIABLE
import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter

SIGNALS = (signal.SIGINT, signal.SIGTERM)
_PRESENT: list[Node] = []


def announce(*, images: bool) -> None:
    """
    Have the middleware make its participant, which others begin to discover, with ROS started.

    It is made with the first node of a process: one that is hidden, and has nothing of its own.
    A signal ends the process at once, and takes the participant with it.

    Parameters
    ----------
    images : bool
        Whether the process publishes whole frames. With the profile of this package its
        shared-memory segment is the smaller one otherwise, as all of it is resident.

    """
    if not images:
        _take_small_segment()
    _PRESENT.append(Node(
        f'_loading_{os.getpid()}',
        use_global_arguments=False,
        enable_rosout=False,
        start_parameter_services=False,
        parameter_overrides=[Parameter('start_type_description_service', value=False)],
    ))
    for number in SIGNALS:
        signal.signal(number, _end)


def settle() -> None:
    """Leave signals to whoever handles them from now on."""
    for number in SIGNALS:
        if signal.getsignal(number) is _end:
            signal.signal(number, signal.SIG_DFL)


def withdraw() -> None:
    """Do without the hidden node, as the nodes are there."""
    while _PRESENT:
        _PRESENT.pop().destroy_node()


def leave() -> None:
    """Be gone again, as it is a long time until the nodes are there."""
    settle()
    withdraw()


def _end(number: int, frame: FrameType | None) -> None:
    """End the process as the signal does, without a participant that seems to live on."""
    leave()
    rclpy.try_shutdown()
    signal.raise_signal(number)


def _take_small_segment() -> None:
    """Have Fast DDS read the profile with the smaller segment in place of the other one."""
    try:
        with open(os.environ.get(VARIABLE, ''), 'rb') as chosen:
            ours = chosen.read() == config_path('fastdds.xml').read_bytes()
    except OSError:
        return
    if ours:
        os.environ[VARIABLE] = str(config_path('fastdds_small.xml'))
