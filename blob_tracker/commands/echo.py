"""Print bearings as they come, with their units; for a machine without `ros2 topic echo`."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from math import inf
import re
import sys

from blob_tracker.commands.exit_code import FAILED
from blob_tracker.ros.bags import RecordingError
from blob_tracker.ros.endpoints.live_rays import listen
from blob_tracker.ros.endpoints.qos import RESULT
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.ray import to_bearing
from blob_tracker.types import Bearing
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.node import Node

NUMBER = re.compile(r'[0-9.]+')
RAY = 'geometry_msgs/msg/PoseWithCovarianceStamped'
SILENCE_S = 2.0  # s without a bearing after which is said what there is


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `python3 -m blob_tracker echo`."""
    parser.add_argument(
        'topic', nargs='?', default='target/ray',
        help='rays, which have the bearing with its covariance (%(default)s)',
    )
    parser.add_argument(
        '--seconds', type=float, default=inf, help='to listen; without it until Ctrl-C'
    )


def main(arguments: argparse.Namespace) -> int:
    """
    Print a line for each bearing, and what the nodes warn of.

    Parameters
    ----------
    arguments : Namespace
        Of the parser that `add_arguments` filled.

    Returns
    -------
    int
        0 if bearings came, else 1.

    """
    echo = Echo()

    def subscribe(node: Node) -> None:
        def look() -> None:
            timer.cancel()
            if not echo.count:
                topics = {
                    name: [each.topic_type for each in node.get_publishers_info_by_topic(name)]
                    for name, _ in node.get_topic_names_and_types()
                }
                words = advice(node.resolve_topic_name(arguments.topic), topics)
                print(
                    f'no bearing on {arguments.topic} so far{words}', file=sys.stderr, flush=True
                )

        timer = node.create_timer(SILENCE_S, look)
        node.create_subscription(PoseWithCovarianceStamped, arguments.topic, echo.show, RESULT)
        node.create_subscription(DiagnosticArray, '/diagnostics', echo.warn, RESULT)

    try:
        listen(subscribe, arguments.seconds)
    except RecordingError as error:
        print(error, file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        pass
    if not echo.count:
        print(f'no bearing came on {arguments.topic}', file=sys.stderr)
    return 0 if echo.count else FAILED


def advice(wanted: str, topics: Mapping[str, Sequence[str]]) -> str:
    """
    Return what to say of a topic that no ray came on.

    Parameters
    ----------
    wanted : str
        Its full name.
    topics : mapping
        What is published: the types of each topic, by its full name.

    """
    rays = sorted(name for name, kinds in topics.items() if RAY in kinds)
    others = [kind for kind in topics.get(wanted, ()) if kind != RAY]
    what = f': it has {others[0]}, and this takes rays, {RAY}' if others else ''
    if not rays:
        return f'{what}; there is no topic of rays: does the locator run, in the same domain?'
    if wanted in rays:
        return '; the locator runs, and what it lacks is in its diagnostics'
    return f'{what}; there is {", ".join(rays)}'


class Echo:
    """
    Print what comes.

    Attributes
    ----------
    count : int
        Of the bearings.

    """

    def __init__(self) -> None:
        self.count = 0
        self._said: dict[str, str] = {}

    def show(self, message: PoseWithCovarianceStamped) -> None:
        """Print a bearing."""
        try:
            bearing = to_bearing(message)
        except MessageError as error:
            print(error, file=sys.stderr)
            return
        self.count += 1
        print(f'{in_words(bearing)}, in {message.header.frame_id}', flush=True)

    def warn(self, message: DiagnosticArray) -> None:
        """Print what is wrong, and why there is no target, once as long as it stays the same."""
        for status in message.status:
            silent = status.message.startswith('no target')
            wrong = status.message if status.level != DiagnosticStatus.OK or silent else ''
            kind = NUMBER.sub('#', wrong)  # other numbers do not make it another sentence
            if wrong and kind != self._said.get(status.name):
                print(f'{status.name.partition(":")[0]}: {wrong}', file=sys.stderr, flush=True)
            self._said[status.name] = kind


def in_words(bearing: Bearing) -> str:
    """Return stamp, angles and their standard deviations with units."""
    seconds, rest = divmod(bearing.stamp_ns, 1_000_000_000)
    azimuth, elevation = bearing.covariance.diagonal() ** 0.5
    return (
        f'{seconds}.{rest:09d} s: azimuth {bearing.azimuth:+.4f} +- {azimuth:.4f} mrad, elevation '
        f'{bearing.elevation:+.4f} +- {elevation:.4f} mrad'
    )
