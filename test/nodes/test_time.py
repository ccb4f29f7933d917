"""A bag gives the same to the last bit: played again, in one process, in simulated time."""

from __future__ import annotations

from contextlib import suppress
import itertools
from math import inf
from pathlib import Path
from typing import Any

from blob_tracker.resources import config_path
from blob_tracker.ros.messages.stamp import from_ns, to_ns
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped, Vector3Stamped
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image
from support.processes import Probe, probe, start, start_replay

BAGS = Path(__file__).parents[1] / 'bags'
BEGIN, END = 1_700_000_000, 1_700_000_002  # s, of the bags
LOCATED = 28  # of 30 lit frames, see test_replay
REPLAY = ('--params-file', str(config_path('replay.yaml')))
RESULTS = (
    (Vector3Stamped, 'target/bearing'),
    (PointStamped, 'target/centroid'),
    (PoseWithCovarianceStamped, 'target/ray'),
)
FRAMES = (Image, 'camera/image_raw'), (CameraInfo, 'camera/camera_info')
BOTH = {'/segmenter: tracking', '/locator: tracking'}
WINDOWS = 'target/window/image_raw', 'target/window/camera_info'
# Nothing is lost on a busy machine, nor before the other end is known.
ALL = QoSProfile(history=HistoryPolicy.KEEP_ALL, durability=DurabilityPolicy.TRANSIENT_LOCAL)
LOSSLESS = {
    f'qos_overrides./{topic}.{end}.{policy}': value
    for topic in (*WINDOWS, *(topic for _, topic in (*RESULTS, *FRAMES)))
    for end in ('publisher', 'subscription')
    for policy, value in (
        ('reliability', 'reliable'), ('history', 'keep_all'), ('durability', 'transient_local'))
}
KEPT = {name: value for name, value in LOSSLESS.items() if name.startswith(tuple(
    f'qos_overrides./{topic}.' for _, topic in RESULTS
))}


def record(node: Probe) -> dict[str, list[Any]]:
    """Record the results of a locator, and what the segmenter and the locator say."""
    for kind, topic in RESULTS:
        node.record(kind, topic, ALL)
    node.record(DiagnosticArray, '/diagnostics')
    return node.received


def results(node: Probe, end_ns: float = inf) -> dict[str, list[tuple[int, str, Any]]]:
    """Return every field of the results of frames up to a stamp, and forget them."""
    fields = {}
    for _, topic in RESULTS:
        fields[topic] = [
            (to_ns(each.header.stamp), each.header.frame_id, str(each))
            for each in node.received[topic] if to_ns(each.header.stamp) <= end_ns
        ]
        node.received[topic].clear()
    return fields


def play(node: Probe, domain: int, bag: str, *arguments: str) -> dict[str, list[Any]]:
    """Play a bag to the end, and return what came of it."""
    with start_replay(BAGS / bag, domain, '--wait', '20', *arguments) as replay:
        node.spin_until(lambda: not replay.running)
        assert replay.wait() == 0, replay.output
    node.spin_until(
        lambda: all(len(node.received[topic]) >= LOCATED for _, topic in RESULTS)
    )
    node.settle(0.3)  # any that should not be there
    return results(node)


def test_a_bag_gives_the_same_however_it_is_played(domain: int) -> None:
    """Twice in simulated time, and twice through the pipeline at another rate, by the stamps."""
    with probe(domain) as node:
        record(node)
        sim = {'use_sim_time': True}
        with (
            start('segmenter', domain, *REPLAY, **sim) as segmenter,
            start('locator', domain, *REPLAY, **sim, **KEPT) as locator,
        ):
            node.spin_until(lambda: node.count_publishers('target/bearing'))
            node.spin_until(lambda: node.count_subscribers('target/window/image_raw'))
            clock = node.create_publisher(Clock, '/clock', 1)
            node.spin_until(lambda: clock.get_subscription_count() >= 2)
            first = play(node, domain, 'flash_mcap', '--clock', '--rate', '2')
            assert len(first['target/bearing']) == LOCATED
            said = [
                (each.header.stamp.sec, each.status[0].message)
                for each in node.received['/diagnostics']
            ]
            assert {stamp for stamp, _ in said if stamp} <= set(range(BEGIN, END + 1))
            assert not any('jumped' in message for _, message in said)

            # An hour later, then back to the beginning.
            later = Clock(clock=from_ns((END + 3600) * 10**9))
            node.spin_until(lambda: clock.publish(later) or BOTH <= {
                each.status[0].name for each in node.received['/diagnostics']
                if each.header.stamp.sec == END + 3600
            })
            node.destroy_publisher(clock)
            second = play(node, domain, 'flash_mcap', '--clock', '--rate', '4')
            node.spin_until(lambda: any(
                '/clock has stopped at ' in each.status[0].message
                for each in node.received['/diagnostics'][-2:]
            ))
            # Once it is known, nothing else is asked for: it was played with --clock.
            assert not any(
                word in each.status[0].message
                for each in node.received['/diagnostics'][-1:]
                for word in ('--clock', 'is a camera publishing', 'the segmenter sees no target')
            )
            wall: ParameterMessage = Parameter('use_sim_time', value=False).to_parameter_msg()
            for name in ('segmenter', 'locator'):
                answer = node.call(
                    SetParameters, f'{name}/set_parameters',
                    SetParameters.Request(parameters=[wall]),
                )
                assert answer.results[0].successful
            node.spin_until(
                lambda: node.received['/diagnostics'][-1].header.stamp.sec > END + 3600
            )
        for process in (segmenter, locator):
            assert 'the ROS clock jumped back by 36' in process.output
            assert 'the ROS clock is now that of the system (use_sim_time)' in process.output
            assert 'Traceback' not in process.output
        node.received['/diagnostics'].clear()

        with start('pipeline', domain, *REPLAY, source='images', **KEPT) as pipeline:
            node.spin_until(lambda: node.count_subscribers('camera/image_raw'))
            third = play(node, domain, 'flash_mcap', '--rate', '1.5')
            fourth = play(node, domain, 'flash_sqlite3', '--rate', '10')
        assert 'camera/image_raw: the stamps jumped back by ' in pipeline.output
    assert len(first['target/ray']) == LOCATED
    assert second == first
    assert third == first
    assert fourth == first


def test_three_processes_give_what_the_pipeline_gave(domain: int) -> None:
    """Frames of a simulator in the pipeline, from the first on, are sent through three."""
    scene = {'width': 200, 'height': 150, 'rate': 60.0}
    with probe(domain) as node:
        record(node)
        images, infos = (node.record(*topic, ALL) for topic in FRAMES)
        with start('pipeline', domain, source='simulator', **scene, **LOSSLESS):
            node.spin_until(lambda: min(len(node.received[topic]) for _, topic in RESULTS) >= 30)
        last = (node.received[topic][-1] for _, topic in (*RESULTS, *FRAMES))
        end_ns = min(to_ns(each.header.stamp) for each in last)
        of_frame = {to_ns(each.header.stamp): each for each in infos}
        frames = [
            (stamp_ns, image, of_frame[stamp_ns]) for image in images
            if (stamp_ns := to_ns(image.header.stamp)) <= end_ns
        ]
        pipeline = results(node, end_ns)
        with start('segmenter', domain, **LOSSLESS), start('locator', domain, **LOSSLESS):
            image_out, info_out = (node.create_publisher(*topic, ALL) for topic in FRAMES)

            def send(until_ns: int, later_ns: int = 0) -> None:
                for stamp_ns, image, info in frames:
                    if stamp_ns <= until_ns:
                        image.header.stamp = info.header.stamp = from_ns(stamp_ns + later_ns)
                        image_out.publish(image)
                        info_out.publish(info)
                        node.spin(0.005)

            # First until all know each other, each time with earlier stamps: the segmenter begins
            # afresh then, and the locator when it is set.
            begin_ns = pipeline['target/bearing'][10][0]
            laters = itertools.count(10**13, -(10**11))

            def answered() -> bool:
                later_ns = next(laters)
                send(begin_ns, later_ns)
                with suppress(AssertionError):
                    node.spin_until(lambda: begin_ns + later_ns in {
                        to_ns(each.header.stamp) for each in node.received['target/ray']
                    }, 1.0)
                    return True
                return False

            node.spin_until(answered)
            assert node.set_parameter('locator', 'noise.online', False).successful
            results(node)
            send(end_ns)
            node.spin_until(lambda: all(
                len(node.received[topic]) >= len(pipeline[topic]) for _, topic in RESULTS
            ))
        processes = results(node)
    assert min(map(len, pipeline.values())) >= 25
    assert processes == pipeline
