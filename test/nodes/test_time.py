"""A bag gives the same to the last bit: played again, in one process, in simulated time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from blob_tracker.resources import config_path
from blob_tracker.ros.messages.stamp import from_ns, to_ns
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped, Vector3Stamped
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
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


def record(node: Probe) -> dict[str, list[Any]]:
    """Record the results of a locator, and what the segmenter and the locator say."""
    for kind, topic in RESULTS:
        node.record(kind, topic)
    node.record(DiagnosticArray, '/diagnostics')
    return node.received


def results(node: Probe) -> dict[str, list[tuple[int, str, Any]]]:
    """Return every field of the results so far, and forget them."""
    fields = {}
    for _, topic in RESULTS:
        fields[topic] = [
            (to_ns(each.header.stamp), each.header.frame_id, str(each))
            for each in node.received[topic]
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
            start('locator', domain, *REPLAY, **sim) as locator,
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
            clock.publish(Clock(clock=from_ns((END + 3600) * 10**9)))
            node.spin_until(
                lambda: node.received['/diagnostics'][-1].header.stamp.sec == END + 3600
            )
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

        with start('pipeline', domain, *REPLAY, source='images') as pipeline:
            node.spin_until(lambda: node.count_subscribers('camera/image_raw'))
            third = play(node, domain, 'flash_mcap', '--rate', '1.5')
            fourth = play(node, domain, 'flash_sqlite3', '--rate', '10')
        assert 'camera/image_raw: the stamps jumped back by ' in pipeline.output
    assert len(first['target/ray']) == LOCATED
    assert second == first
    assert third == first
    assert fourth == first


def test_three_processes_give_what_the_pipeline_gave(domain: int) -> None:
    """Frames of a simulator in the pipeline, recorded and sent through three processes."""
    with probe(domain) as node:
        record(node)
        images = node.record(Image, 'camera/image_raw')
        infos = node.record(CameraInfo, 'camera/camera_info')
        with start(
            'pipeline', domain, source='simulator', width=200, height=150, rate=60.0
        ):
            # Twice as many as are asked for below: a machine that stalls loses the light for some.
            node.spin_until(lambda: len(images) >= 180 and len(infos) >= 180)
        pipeline = results(node)
        recorded = {to_ns(each.header.stamp): each for each in infos}
        frames = [each for each in images if to_ns(each.header.stamp) in recorded]
        with start('segmenter', domain, *REPLAY), start('locator', domain, *REPLAY):
            node.spin_until(lambda: node.count_publishers('target/bearing'))
            node.spin_until(lambda: node.count_subscribers('target/window/image_raw'))
            image_out = node.create_publisher(Image, 'camera/image_raw', 200)
            info_out = node.create_publisher(CameraInfo, 'camera/camera_info', 200)
            # The probe's own and the segmenter's.
            node.spin_until(lambda: image_out.get_subscription_count() > 1)
            node.spin_until(lambda: info_out.get_subscription_count() > 1)
            for frame in frames:
                image_out.publish(frame)
                info_out.publish(recorded[to_ns(frame.header.stamp)])
                node.spin(0.005)
            node.spin_until(lambda: len(node.received['target/ray']) >= 30)
            node.settle(0.5)
        processes = results(node)
    # The pipeline had followed the light before the recording began: it needs some flashes.
    begin = processes['target/bearing'][5][0]
    end = to_ns(frames[-1].header.stamp)
    for _, topic in RESULTS:
        one, three = (
            [each for each in run[topic] if begin <= each[0] <= end]
            for run in (pipeline, processes)
        )
        assert len(one) >= 25
        assert three == one
