"""The simulator flies a body and tells its pose; lights that are not the body's are refused."""

from __future__ import annotations

from blob_tracker.commands.demo import BODY_URL, LIGHTS
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.simulation.flying_body import Flight
from geometry_msgs.msg import PoseStamped
import numpy as np
from support.processes import probe, start

PARAMETERS = {name.replace('.', '__'): value for name, value in LIGHTS['constellation'][0].items()}


def test_the_pose_of_the_body_is_told(domain: int) -> None:
    """In each frame, along its flight from the first frame on."""
    with probe(domain) as node, start(
        'simulator', domain, rate=20.0, width=160, height=120, body_url=BODY_URL, **PARAMETERS,
    ):
        poses = node.record(PoseStamped, 'simulator/truth/pose')
        node.spin_until(lambda: len(poses) >= 20)
    places = np.array([
        [each.pose.position.x, each.pose.position.y, each.pose.position.z] for each in poses
    ])
    times = 1e-9 * np.array([to_ns(each.header.stamp) - to_ns(poses[0].header.stamp)
                             for each in poses])

    def away(time: float) -> float:
        return float(np.abs(Flight().pose(time)[1] - places[0]).max())

    begin = min(np.arange(0.0, 9.0, 0.05).tolist(), key=away)
    true = np.array([Flight().pose(begin + time)[1] for time in times])
    np.testing.assert_allclose(places, true, atol=1e-6)


def test_other_lights_than_the_bodys_are_refused(domain: int) -> None:
    """The names of both are in the sentence."""
    with start('simulator', domain, body_url=BODY_URL) as process:
        assert process.wait() == 2
        assert 'nose, port, starboard, tail, mast, and flash.codes' in process.output
