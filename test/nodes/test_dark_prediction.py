"""Between its flashes a coded light that moves is predicted on, from when it was seen."""

from __future__ import annotations

from collections.abc import Iterator

from blob_tracker import CameraModel, Pipeline, SensorNoise
from blob_tracker.camera import pinhole_matrix
from blob_tracker.ros.endpoints.qos import RESULT, STATE
from blob_tracker.ros.messages.stamp import from_ns, to_ns
from blob_tracker.ros.messages.target import ray_message
from blob_tracker.segmentation import flash_by_name, Segmenter
from blob_tracker.simulation import blinking_lights, truth_of, waveforms_of
from blob_tracker.tracking import Tracker
from blob_tracker.types import Bearing, Frame
from geometry_msgs.msg import PoseWithCovarianceStamped, Vector3Stamped
from nav_msgs.msg import Odometry
import numpy as np
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool
from support.processes import probe, start

RATE, EXPOSURE = 60.0, 0.5
MOTION = 'constant_acceleration'
CODES = {'mast': '1101101010', 'starboard': '1100100100'}  # dark for up to one and two bits
BITS_PER_SECOND = 59.7
FRAMES = 200
LENS = 600.0  # px
MODEL = CameraModel(640, 480, pinhole_matrix(LENS, 640, 480))
# The path takes them through the picture at 8 px a frame in the mean, 11.6 at the most.
SCENE, LIGHTS = blinking_lights(
    waveforms_of('coded', codes=CODES, bits_per_second=BITS_PER_SECOND), period=6.0, rate=RATE
)
# px rms a coordinate after up to two and three frames: of an acceleration that is known from some
# places of 0.02 px, and changes by up to 0.02 px a frame^3.
BUDGETS = {'mast': 0.15, 'starboard': 0.25}


def stamp_ns(index: int) -> int:
    """Return the middle of a frame's exposure."""
    return 10**18 + round(1e9 * index / RATE)


def seen() -> list[dict[str, Bearing]]:
    """Return the bearings that come of each frame, by name."""
    segmenter = Segmenter(flash=flash_by_name(
        'coded', codes=CODES, bits_per_second=BITS_PER_SECOND, exposure=EXPOSURE / RATE
    ))
    pipeline = Pipeline(MODEL, noise=SensorNoise(40.0, 0.7), segmenter=segmenter)
    return [
        dict(pipeline.named([Frame(SCENE.frame(index), stamp_ns(index), 255)]))
        for index in range(FRAMES)
    ]


def tracked_with(frames: list[dict[str, Bearing]], name: str) -> list[bool]:
    """Return for each frame whether its bearing of a light makes part of a track that is told."""
    tracker, found = Tracker(MOTION), []
    for each in frames:
        if name in each:
            tracker.update(each[name])
        found.append(name in each and tracker.seen_at(each[name].stamp_ns) is not None)
    return found


def true_angles(name: str, at_ns: int) -> tuple[float, float]:
    """Return where a light is, mrad."""
    x, y, *_ = LIGHTS[name].spot((at_ns - stamp_ns(0)) / 1e9)
    azimuth, elevation, _ = MODEL.angles(x, y)
    return azimuth, elevation


def instants() -> Iterator[tuple[int, int]]:
    """Yield each frame and the times of its interval at which something is to be predicted."""
    for index in range(FRAMES):
        for part in range(3):
            yield index, stamp_ns(index) + round(1e9 * (0.5 * EXPOSURE + part / 3) / RATE)


def test_the_prediction_goes_on_while_the_light_is_dark(domain: int) -> None:
    """In simulated time: with the stamps of the bearings, and as near as the motion lets it be."""
    bearings = seen()
    passed = {name: tracked_with(bearings, name) for name in CODES}
    with probe(domain) as node, start(
        'tracker', domain, use_sim_time=True, lights=','.join(CODES),
        model=MOTION, prediction_rate=500.0,
    ):
        clock = node.create_publisher(Clock, '/clock', 10)
        predictions, tracks, tracked, rays = {}, {}, {}, {}
        for name in CODES:
            topic = f'target/{name}'
            predictions[name] = node.record(Vector3Stamped, f'{topic}/bearing_predicted', 1000)
            tracks[name] = node.record(Odometry, f'{topic}/track', 1000)
            tracked[name] = node.record(Bool, f'{topic}/tracked', STATE)
            rays[name] = node.create_publisher(PoseWithCovarianceStamped, f'{topic}/ray', RESULT)
        node.spin_until(lambda: clock.get_subscription_count() and all(
            each.get_subscription_count() for each in rays.values()
        ) and all(
            node.count_publishers(f'target/{name}/track') for name in CODES
        ))
        node.meet('tracker')
        sent = dict.fromkeys(CODES, 0)
        last = -1
        for index, now_ns in instants():
            clock.publish(Clock(clock=from_ns(now_ns)))
            if index != last:
                last = index
                for name, bearing in bearings[index].items():
                    rays[name].publish(ray_message(bearing, 'camera_optical_frame'))
                    sent[name] += passed[name][index]
                node.spin_until(lambda: all(len(tracks[name]) >= sent[name] for name in CODES))
            node.spin(0.002)
        node.settle(0.3)
    for name in CODES:
        assert len(tracks[name]) == sent[name] > 90
        # Each bearing is at the instant at which the light was seen, not at the frame's stamp.
        said = {to_ns(each.header.stamp) for each in tracks[name]}
        assert said == {
            each[name].stamp_ns for each, right in zip(bearings, passed[name]) if right
        }
        assert len(said - {stamp_ns(index) for index in range(FRAMES)}) > 10
        errors, due = [], set()
        for index, now_ns in instants():
            dark = truth_of(LIGHTS[name], SCENE.shot(index)).amplitude == 0.0
            if dark and index > 60:
                due.add(now_ns)
        told = {to_ns(each.header.stamp): each.vector for each in predictions[name]}
        # All but those whose clock the node had not taken yet when the next one came.
        assert len(due & set(told)) > 0.5 * len(due) > 50
        for now_ns in due & set(told):
            azimuth, elevation = true_angles(name, now_ns)
            errors.append((told[now_ns].x - azimuth, told[now_ns].y - elevation))
        rms = np.sqrt(np.mean(np.square(errors)))
        assert rms <= 1e3 * BUDGETS[name] / LENS, name
        # Once, without a break, until simulated time stands still.
        assert [each.data for each in tracked[name]].count(True) == 1
