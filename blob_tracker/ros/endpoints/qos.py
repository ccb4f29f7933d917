"""Quality of service of the topics; each can be overridden by the standard parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import copy
from functools import partial
from inspect import signature
import re
import time
from typing import Any

from blob_tracker.ros.errors import ParameterError
from rclpy.context import Context
from rclpy.event_handler import (
    PublisherEventCallbacks, QoSMessageLostInfo, SubscriptionEventCallbacks,
)
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import (
    DurabilityPolicy, HistoryPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy,
)
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription

# A driver offers reliable images, a consumer asks for best effort (REP 2003): both match, and a
# recorder may ask for more. Ten frames ride out the pause of a garbage collection at 300 Hz.
IMAGE_OUT = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
IMAGE_IN = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
# Of an IMU or of joints, likewise: a tenth of a second at 1 kHz.
SAMPLES_IN = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
RESULT = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
STATE = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
# Of tf2_ros' listener and broadcasters. A static transform is sent once, and by many nodes.
TF = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
TF_STATIC = QoSProfile(
    depth=100,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)

# What a publisher and a subscription may disagree on, and how many messages wait.
OVERRIDABLE = {
    'history': HistoryPolicy,
    'depth': int,
    'reliability': ReliabilityPolicy,
    'durability': DurabilityPolicy,
}
MOST = 100_000  # messages in a queue
_OF_A_LIGHT = re.compile(r'target/[^/]+/(.+)')
ASK_NS = 20_000_000  # ns from one question whether anybody listens to the next


class QuietPublisher(Publisher):
    """
    A publisher that says nothing once ROS has ended.

    A signal ends the context while a callback runs, maybe between two messages of its own. What
    it still publishes is for nobody, and no reason for a trace on the terminal.

    Parameters
    ----------
    context : Context
        Of its node.
    arguments, options
        As rclpy makes it.

    """

    def __init__(self, context: Context, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._context = context
        self._held = self.handle
        self._is_latched = self.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        self._heard, self._asked_ns = False, -ASK_NS  # whether anybody listened when it was asked

    def publish(self, msg: Any) -> None:
        """Publish a message, or the bytes of one, if ROS is still there."""
        try:
            if type(msg) is bytes:  # as rclpy does, which looks for all else first
                with self._held:
                    self._held.publish_raw(msg)
            else:
                super().publish(msg)
        except RuntimeError:  # of rclpy's C layer, whose type is not public
            if self._context.ok():
                raise

    @property
    def is_wanted(self) -> bool:
        """Whether anybody listens, or will be given the last messages once he does."""
        if self._is_latched:
            return True
        now_ns = time.monotonic_ns()
        if now_ns - self._asked_ns >= ASK_NS:
            self._heard, self._asked_ns = self.get_subscription_count() > 0, now_ns
        return self._heard

    def get_subscription_count(self) -> int:
        """Return how many listen: nobody where ROS has ended."""
        try:
            with self._held:  # as rclpy does
                return int(self._held.get_subscription_count())
        except RuntimeError:
            if self._context.ok():
                raise
            return 0


def publisher(node: Node, kind: type, topic: str, qos: QoSProfile) -> QuietPublisher:
    """
    Return a publisher whose profile the parameters qos_overrides.<topic>.publisher... change.

    Where ROS has ended meanwhile it publishes nothing, without a word.

    Raises
    ------
    ParameterError
        If one of them is wrong.

    """
    quiet: QuietPublisher = node.create_publisher(
        kind,
        topic,
        _profile(node, topic, 'publisher', qos),
        qos_overriding_options=_options(node, topic, 'publisher'),
        # `Connections` tells more; the plain executor asks each of rclpy's own at every message.
        event_callbacks=PublisherEventCallbacks(use_default_callbacks=False),
        publisher_class=partial(QuietPublisher, node.context),
    )
    return quiet


def subscription(
    node: Node,
    kind: type,
    topic: str,
    take: Callable[..., None],
    qos: QoSProfile,
    lost: Callable[[QoSMessageLostInfo], None] | None = None,
    *,
    informed: bool = False,
) -> Subscription:
    """
    Return a subscription whose profile qos_overrides.<topic>.subscription... change.

    Parameters
    ----------
    node : Node
        Subscribes.
    kind : type
        Of the messages.
    topic : str
        Name of the topic.
    take : callable
        Called with each message; where `lost` is given or it is to be informed, with what the
        middleware says of it, too.
    qos : QoSProfile
        The profile where nothing is overridden.
    lost : callable, optional
        Called where messages were lost on their way here.
    informed : bool
        Whether `take` wants what the middleware says of a message.

    Raises
    ------
    ParameterError
        If an override is wrong.

    """
    return node.create_subscription(
        kind,
        topic,
        _informed(take) if informed or lost is not None else take,
        _profile(node, topic, 'subscription', qos),
        qos_overriding_options=_options(node, topic, 'subscription'),
        event_callbacks=SubscriptionEventCallbacks(
            message_lost=lost, use_default_callbacks=False
        ),
    )


def _informed(take: Callable[[Any, Any], None]) -> Callable[..., None]:
    """Return a callback of two arguments that both of rclpy's executors can call."""

    def called(*taken: Any) -> None:
        # The EventsExecutor of rclpy 7.1 hands both over in one tuple.
        message, information = taken if len(taken) == 2 else taken[0]
        take(message, information)

    # By which rclpy tells whether a callback wants both.
    called.__signature__ = signature(take)  # type: ignore[attr-defined]
    return called


def _profile(node: Node, topic: str, end: str, qos: QoSProfile) -> QoSProfile:
    """Return a profile for one topic: what is overridden of target/ray is for each light's."""
    profile = copy(qos)  # rclpy writes the overrides of this topic into it
    if of_light := _OF_A_LIGHT.fullmatch(topic):
        for policy, value in _overrides(node, f'target/{of_light[1]}', end):
            kind = OVERRIDABLE[policy]
            setattr(profile, policy, value if kind is int else kind[value.upper()])
    return profile


def _options(node: Node, topic: str, end: str) -> QoSOverridingOptions:
    """Return what may be overridden, once what was given at start-up is seen to be possible."""
    list(_overrides(node, topic, end))
    return QoSOverridingOptions([QoSPolicyKind[each.upper()] for each in OVERRIDABLE])


def _overrides(node: Node, topic: str, end: str) -> Iterator[tuple[str, Any]]:
    """Yield each policy that was given at start-up for an end of a topic, and its value."""
    prefix = f'qos_overrides.{node.resolve_topic_name(topic)}.{end}.'
    # What rclpy was told at start-up is not public; rclpy drops a policy with a misspelt name.
    for name, parameter in node._parameter_overrides.items():
        if name.startswith(prefix):
            policy = name.removeprefix(prefix)
            _check(name, policy, parameter.value)
            yield policy, parameter.value


def _check(name: str, policy: str, value: Any) -> None:
    """Raise ParameterError if a policy cannot have this value."""
    if policy not in OVERRIDABLE:
        raise ParameterError(
            f"no parameter '{name}'; what can be overridden is {', '.join(OVERRIDABLE)}"
        )
    values = OVERRIDABLE[policy]
    if values is int:
        if type(value) is not int or not 1 <= value <= MOST:
            raise ParameterError(
                f"parameter '{name}' is {value!r}; it must be an integer from 1 to {MOST}"
            )
        return
    choices = [each.name.lower() for each in values if each.name != 'UNKNOWN']
    if value not in choices:
        raise ParameterError(
            f"parameter '{name}' is {value!r}; it must be one of {', '.join(choices)}"
        )
