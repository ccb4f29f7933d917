"""
/tf and /tf_static: read into a tree of transforms, and published.

Not by tf2_ros: to wait with its buffer takes a second thread, its filter that holds messages back
is for C++, it believes whoever named a frame's parent last, and where no ROS is installed there is
none. Two topics, their QoS and one message are all that there is to TF.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from functools import partial
import math
import time
from typing import Any

from blob_tracker.ros.diagnostics.health import ERROR, Health, WARN
from blob_tracker.ros.diagnostics.interleaving import Interleaving
from blob_tracker.ros.endpoints.qos import publisher, QuietPublisher, subscription, TF, TF_STATIC
from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.ros.messages.transform import to_transform
from blob_tracker.transforms import (
    Found, NoTransform, Transform, TransformError, TransformTree,
)
from geometry_msgs.msg import TransformStamped
import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node

# rad by which turns of parameters and of TF may differ that are said to agree: those of a drawing,
# and of a camera that was screwed on by hand.
AGREED_RAD = 0.01
APART_NS = 1_000_000_000  # ns: no transform is so late, a clock may be
MOST_REFUSED = 20  # frames of which it is kept why their transforms were refused


class Transforms:
    """
    Keep what comes on /tf and /tf_static.

    Parameters
    ----------
    node : Node
        Subscribes.
    health : Health
        Hears of transforms that cannot be used.
    came : callable
        Called after each message, with the lock held.
    lock : context manager
        Of all that is done with the transforms.
    hold : float
        Longest time between two transforms that are interpolated, s.
    asked_by : str
        The parameter that asks for them.

    Raises
    ------
    ParameterError
        If the messages are not installed.

    """

    def __init__(
        self,
        node: Node,
        health: Health,
        came: Callable[[], None],
        lock: AbstractContextManager[Any],
        *,
        hold: float,
        asked_by: str,
    ) -> None:
        kind = tf_message(asked_by)
        self._health, self._came, self._lock = health, came, lock
        self._tree = TransformTree(hold)
        self._refused: dict[str, str] = {}  # why, by the frame
        self._came_ns: dict[str, int] = {}  # monotonic time of the last of each frame that moves
        self._senders: dict[str, Interleaving] = {}  # of each frame that moves
        subscription(node, kind, '/tf', self._take_moving, TF, informed=True)
        subscription(node, kind, '/tf_static', partial(self._take, self._put_static), TF_STATIC)

    def lookup(self, frame: str, reference: str, stamp_ns: int) -> Found:
        """
        Return how a frame lies in another at an instant, ns; the lock is held.

        Raises
        ------
        NoTransform
            If it is not known: `explain` says why.

        """
        return self._tree.lookup(frame, reference, stamp_ns)

    def fixed(self, frame: str, reference: str) -> Transform:
        """Return how a frame lies in another for good, else as `lookup`."""
        return self._tree.fixed(frame, reference)

    def explain(self, gap: NoTransform) -> str:
        """Return why a transform is not known, and what to do."""
        came_ns = self._came_ns.get(gap.frame)
        if came_ns is not None and gap.apart_ns > APART_NS:
            if time.monotonic_ns() - came_ns < APART_NS:
                return (
                    f'{gap}, and they come all the time: their stamps are of another clock than '
                    'those of the rays; set both machines by NTP or PTP, and use_sim_time alike'
                )
            return f'{gap}, and no more come: is their publisher still running?'
        refused = '; '.join(self._refused.values())
        return f'{gap}; refused was: {refused}' if refused else str(gap)

    def forget(self, after_ns: int) -> None:
        """Forget what has a later stamp, ns; the lock is held."""
        self._tree.forget(after_ns)

    def _take_moving(self, message: Any, information: Mapping[str, int | None]) -> None:
        """Take the transforms of a message on /tf, and say which frames several nodes publish."""
        number, sent_ns = (
            information[each] for each in ('publication_sequence_number', 'source_timestamp')
        )
        if number is not None and sent_ns is not None:  # not every middleware numbers them
            for each in message.transforms:
                sender = self._senders.setdefault(each.child_frame_id, Interleaving())
                sender.took(number, sent_ns)
                if sender.mixed:
                    self._health.fault(
                        WARN,
                        f"several nodes publish '{each.child_frame_id:.80}' on /tf, and it is "
                        'interpolated between what they say in turns: let one of them do so',
                    )
        self._take(self._put, message)

    def _take(self, put: Callable[[TransformStamped], None], message: Any) -> None:
        """Take the transforms of a message."""
        with self._lock:
            for each in message.transforms:
                try:
                    put(each)
                    self._refused.pop(each.child_frame_id, None)
                except TransformError as error:
                    self._refuse(each, str(error))
            self._came()

    def _put(self, message: TransformStamped) -> None:
        """Take a transform of /tf."""
        frame = message.child_frame_id
        jumped = self._tree.put(
            frame, message.header.frame_id, to_transform(message), to_ns(message.header.stamp)
        )
        self._came_ns[frame] = time.monotonic_ns()
        if jumped:
            self._health.fault(
                WARN,
                f"/tf: the stamps of '{frame}' jumped back by {jumped:.3f} s; starting again",
            )

    def _put_static(self, message: TransformStamped) -> None:
        """Take a transform of /tf_static."""
        self._tree.put_static(
            message.child_frame_id, message.header.frame_id, to_transform(message)
        )

    def _refuse(self, message: TransformStamped, reason: str) -> None:
        """Say why a transform is not used."""
        frame, parent = message.child_frame_id, message.header.frame_id
        words = f"the transform of '{frame:.80}' in '{parent:.80}': {reason}"
        if frame in self._refused or len(self._refused) < MOST_REFUSED:
            self._refused[frame] = words
        self._health.fault(ERROR, f'TF: {words}')
        self._health.count('transforms refused')


class TransformBroadcaster:
    """
    Publish transforms on /tf.

    Parameters
    ----------
    node : Node
        Publishes.
    asked_by : str
        The parameter that asks for it.

    Raises
    ------
    ParameterError
        If the messages are not installed.

    """

    def __init__(self, node: Node, asked_by: str) -> None:
        self._kind = tf_message(asked_by)
        self._publisher: QuietPublisher = publisher(node, self._kind, '/tf', TF)

    def send(self, transforms: Sequence[TransformStamped]) -> None:
        """Publish transforms."""
        self._publisher.publish(self._kind(transforms=transforms))


def angle_between(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Return the angle of the turn from one (3, 3) turn to another, rad."""
    # Of the difference, which is 2 sqrt(2) sin(angle / 2) long: small angles keep their digits.
    chord = float(np.linalg.norm(one - other)) / math.sqrt(8.0)
    return 2.0 * math.asin(min(chord, 1.0))


def tf_message(asked_by: str) -> Any:
    """
    Return the type of /tf and /tf_static.

    Raises
    ------
    ParameterError
        If it is not installed, with the parameter that asks for it.

    """
    try:
        from tf2_msgs.msg import TFMessage
    except ImportError as error:
        raise ParameterError(
            f"parameter '{asked_by}' asks for TF, and tf2_msgs cannot be imported ({error}): "
            'install it (sudo apt install ros-jazzy-tf2-msgs), or leave the parameter false and '
            'give rotations and positions by parameters; tf2_msgs is on no Python registry'
        ) from None
    return TFMessage
