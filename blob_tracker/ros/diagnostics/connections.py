"""Who is at the other end of a node's topics, and why nothing comes or goes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence

from blob_tracker.ros.diagnostics.health import Health, WARN
from blob_tracker.ros.diagnostics.shared_memory import barrier, by_network, FOLDER, same_host
from blob_tracker.ros.endpoints.qos import OVERRIDABLE
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy,
    LivelinessPolicy,
    qos_check_compatible,
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.topic_endpoint_info import TopicEndpointInfo

COMMON = ('/diagnostics', '/parameter_events', '/rosout')  # to which all nodes publish
# Each publisher has a part of what they say together: its joints, its frames.
PARTED = ('joint_states', '/tf', '/tf_static')
SETTLED = 2  # checks: one node may leave as another comes
# Checks: a node that was killed is taken for alive until its lease ends (20 s in rmw_fastrtps),
# and one of the same name is likely to be that node, started again.
LEASE = 25
# What is offered is more than what is asked for.
_ENOUGH = (
    (ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT),
    (DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE),
    (LivelinessPolicy.MANUAL_BY_TOPIC, LivelinessPolicy.AUTOMATIC),
)


class Publishers:
    """
    Tell whether several nodes publish a topic, once it is sure.

    Attributes
    ----------
    names : list of str
        Of those that did at the last check, each once.
    count : int
        Nodes that did.

    """

    def __init__(self) -> None:
        self.names: list[str] = []
        self.count = 0
        self._checks = 0  # in which there were several

    def check(self, publishers: Iterable[TopicEndpointInfo]) -> None:
        """Take the publishers of the graph, once a second."""
        # One node may have several publishers: those of one participant, whose GUIDs begin alike.
        nodes = {(full_name(each), bytes(each.endpoint_gid)[:12]) for each in publishers}
        self.count = len(nodes)
        self.names = sorted({name for name, _ in nodes})
        self._checks = self._checks + 1 if self.count > 1 else 0

    @property
    def several(self) -> bool:
        """Whether there are several, and none is likely to be one that has ended."""
        return self._checks >= (LEASE if len(self.names) == 1 else SETTLED)


class Connections:
    """
    Report what keeps a node and those at the other ends of its topics from understanding.

    Once a second, from the graph: publishers and subscriptions of an incompatible quality of
    service or another type, and topics that are published twice though they are no sum of parts,
    each with the names of the nodes.

    Parameters
    ----------
    node : Node
        Whose topics they are.
    health : Health
        Is told.

    """

    def __init__(self, node: Node, health: Health) -> None:
        self._node = node
        self._health = health
        self._publishers: defaultdict[str, Publishers] = defaultdict(Publishers)
        health.watch(self._check)
        health.explain_silence(lambda: no_clock(node) or why_silent(node))

    def _check(self) -> None:
        """Look at the other end of each topic."""
        graph = self._node
        published = {each.topic_name for each in graph.publishers}
        subscribed = {each.topic_name for each in graph.subscriptions}
        parted = {graph.resolve_topic_name(each) for each in PARTED}
        for topic in sorted(published | subscribed):
            publishers = graph.get_publishers_info_by_topic(topic)
            subscriptions = graph.get_subscriptions_info_by_topic(topic)
            # As the graph has them: a profile may leave a policy to the middleware.
            for ours in own(graph, subscriptions):
                self._warn(unheard(topic, ours, each) for each in publishers)
            for ours in own(graph, publishers):
                self._warn(unhearing(topic, ours, each) for each in subscriptions)
            if topic not in COMMON and topic not in parted:
                self._warn([self._published_twice(topic, publishers)])
        if not self._health.starting:
            self._warn([no_clock(graph)])

    def _published_twice(self, topic: str, publishers: Sequence[TopicEndpointInfo]) -> str:
        """Return what to say of a topic that several nodes publish, once it is sure."""
        known = self._publishers[topic]
        known.check(publishers)
        names = known.names
        if not known.several:
            return ''
        if len(names) == 1:
            return (
                f'{known.count} nodes of the name {names[0]} publish {topic}; stop all but one, '
                'or give each its own name or namespace'
            )
        return f'{len(names)} nodes publish {topic}: {", ".join(names)}; stop all but one'

    def _warn(self, sentences: Iterable[str]) -> None:
        """Report what there is to say."""
        for sentence in sentences:
            if sentence:
                self._health.fault(WARN, sentence)


def no_clock(node: Node) -> str:
    """Return that a node's simulated time stands still; empty if somebody publishes it."""
    clock = node.get_clock()
    if not clock.ros_time_is_active or node.count_publishers('/clock'):
        return ''
    if seconds := clock.now().nanoseconds / 1e9:
        return (
            f'/clock has stopped at {seconds:.3f} s and nothing publishes /clock any more: the '
            'bag or the simulation has ended; start it again, or set use_sim_time to false'
        )
    return (
        'use_sim_time is true and nothing publishes /clock, so that ROS time stands still; play '
        'the bag with --clock, start the simulation, or set use_sim_time to false'
    )


def why_silent(node: Node) -> str:
    """Return why nothing comes of a publisher of a node's topics; empty if this is not seen."""
    for topic in sorted({each.topic_name for each in node.subscriptions} - {*COMMON}):
        for ours in own(node, node.get_subscriptions_info_by_topic(topic)):
            for each in node.get_publishers_info_by_topic(topic):
                if reason := unheard(topic, ours, each) or unreachable(topic, ours, each):
                    return reason
    return ''


def own(node: Node, endpoints: Iterable[TopicEndpointInfo]) -> list[TopicEndpointInfo]:
    """Return those of a node."""
    return [each for each in endpoints if full_name(each) == node.get_fully_qualified_name()]


def unheard(topic: str, ours: TopicEndpointInfo, publisher: TopicEndpointInfo) -> str:
    """
    Return why a subscription hears nothing of a publisher; empty if it does.

    Parameters
    ----------
    topic : str
        Full name of the topic.
    ours : TopicEndpointInfo
        The subscription of this node, of the graph.
    publisher : TopicEndpointInfo
        Of another node.

    """
    name = full_name(publisher)
    if publisher.topic_type != ours.topic_type:
        return (
            f'{topic}: {name} publishes {publisher.topic_type} there and this node takes '
            f'{ours.topic_type}; remap one of the two'
        )
    return '; '.join(
        f'{topic}: {name} publishes {offered} and this node asks for {asked}, so that nothing '
        f'arrives from it; set its {policy} to {asked}'
        + _or_override(topic, 'subscription', policy, offered)
        for policy, offered, asked in disagreements(publisher.qos_profile, ours.qos_profile)
    )


def unhearing(topic: str, ours: TopicEndpointInfo, subscription: TopicEndpointInfo) -> str:
    """Return why a subscription hears nothing of this node; as `unheard`, from the other end."""
    name = full_name(subscription)
    if subscription.topic_type != ours.topic_type:
        return (
            f'{topic}: {name} takes {subscription.topic_type} there and this node publishes '
            f'{ours.topic_type}; remap one of the two'
        )
    return '; '.join(
        f'{topic}: {name} asks for {asked} and this node publishes {offered}, so that it hears '
        f'nothing; set its {policy} to {offered}'
        + _or_override(topic, 'publisher', policy, asked)
        for policy, offered, asked in disagreements(ours.qos_profile, subscription.qos_profile)
    )


def unreachable(topic: str, ours: TopicEndpointInfo, publisher: TopicEndpointInfo) -> str:
    """Return why nothing comes of a publisher that fits; empty if nothing speaks against it."""
    gid = bytes(publisher.endpoint_gid)
    if unheard(topic, ours, publisher) or not same_host(gid, bytes(ours.endpoint_gid)):
        return ''
    reason = barrier(gid)
    if not reason:
        return ''
    return (
        f'{topic}: a publisher is known and nothing comes through shared memory: {reason}; run '
        f'both as one user and with one {FOLDER} (containers with --ipc=host), or have one of the '
        f'two do without: in its terminal, before it starts, type: {by_network()}'
    )


def disagreements(offered: QoSProfile, asked: QoSProfile) -> list[tuple[str, str, str]]:
    """Return each policy on which the two ends of a topic disagree: name, offered and asked."""
    compatibility, _ = qos_check_compatible(offered, asked)
    if compatibility != QoSCompatibility.ERROR:
        return []
    # A publisher may offer more than is asked for, in each of these.
    return [
        (policy, _in_words(ours), _in_words(theirs))
        for policy in ('reliability', 'durability', 'deadline', 'liveliness',
                       'liveliness_lease_duration')
        if (ours := getattr(offered, policy)) != (theirs := getattr(asked, policy))
        and (ours, theirs) not in _ENOUGH
        and not (isinstance(ours, Duration) and ours < theirs)
    ]


def _or_override(topic: str, end: str, policy: str, value: str) -> str:
    """Return what this node may do about a policy, where it may."""
    if policy not in OVERRIDABLE:
        return ''
    return f', or qos_overrides.{topic}.{end}.{policy} of this node to {value}'


def _in_words(value: object) -> str:
    """Return the value of a policy as the parameters have it."""
    if isinstance(value, Duration):
        return f'{value.nanoseconds / 1e9:g} s'
    return str(value.name).lower()  # type: ignore[attr-defined]


def full_name(endpoint: TopicEndpointInfo) -> str:
    """Return the name of an endpoint's node with its namespace."""
    if endpoint.node_name == '_NODE_NAME_UNKNOWN_':  # not told yet, or no node of ROS
        return 'a node without a name'
    return f'{endpoint.node_namespace.rstrip("/")}/{endpoint.node_name}'
