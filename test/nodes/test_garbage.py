"""Ten thousand messages of garbage through running nodes: no crash, and no wrong bearing."""

from __future__ import annotations

from array import array
from collections.abc import Collection, Iterator
from contextlib import ExitStack
from itertools import count
from math import nan, pi
from typing import Any

from blob_tracker.ros.endpoints.qos import STATE
from blob_tracker.ros.messages.stamp import from_ns, to_ns
from blob_tracker.ros.messages.target import ray_message
from blob_tracker.ros.messages.track import to_track
from blob_tracker.simulation import flashing_light
from blob_tracker.types import Bearing
from geometry_msgs.msg import PoseWithCovarianceStamped, Vector3, Vector3Stamped
from hypothesis import example, given, HealthCheck, Phase, settings, strategies as st
from nav_msgs.msg import Odometry
import numpy as np
import pytest
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import CameraInfo, Image, Imu, JointState
from support.played_camera import PlayedCamera, Sent, STEP_NS
from support.processes import probe, Process, start

PAIRS = 40  # of image and camera_info in a batch; hypothesis makes no longer lists
BATCHES = 63  # so many for each arrangement: 2 * 63 * 40 * 2 are more than 10,000 messages
TAKE = 0.02  # s after each batch to take what has come of it
GOOD = 9  # batches between two looks at whether good frames are still tracked
# Deep queues, reliable at both ends: every message reaches the node.
DEEP = QoSProfile(depth=2000, reliability=ReliabilityPolicy.RELIABLE)
SCENE = flashing_light(width=96, height=64, period=3.0)
U32 = st.integers(0, 2**32 - 1) | st.sampled_from((0, 1, 2, 64, 96, 255, 2**31, 2**32 - 1))
STAMP = st.tuples(
    st.integers(-(2**31), 2**31 - 1) | st.sampled_from((0, -1, -(2**31), 2**31 - 1)),
    U32,
) | st.sampled_from(
    ((2**31 - 1, 10**9 - 1), (2**31 - 1, 2**32 - 1), (-(2**31), 0), (0, 0), (0, 10**9))
)
NUMBER = st.floats() | st.sampled_from((0.0, 1e-300, 5e-324, 1e300, -1.0, 0.5, 300.0))
MODELS = ('', 'plumb_bob', 'rational_polynomial', 'equidistant', 'fisheye')
ENCODINGS = ('mono8', 'mono16', '8UC1', '16UC1', '8UC2', '16UC2', 'rgb8', 'bgra8', '32FC1')


def _one_of(fields: dict[str, st.SearchStrategy[Any]]) -> st.SearchStrategy[tuple[str, Any]]:
    return st.one_of(*(st.tuples(st.just(name), value) for name, value in fields.items()))


HEADER = {
    'frame_id': st.text(max_size=40),
    'stamp': STAMP,
    # From the last message's stamp, ns: equal, backwards, far ahead.
    'step': st.sampled_from((0, -1, -16_666_667, -(10**9), 10**9, 10**12)),
}
IMAGE = _one_of(HEADER | {
    'encoding': st.sampled_from(ENCODINGS) | st.text(max_size=60),
    'width': U32,
    'height': U32,
    'step_bytes': U32,
    'is_bigendian': st.integers(0, 255),
    'data': st.integers(0, 4 * 96 * 64) | st.sampled_from((0, 1, 96 * 64 - 1, 2 * 96 * 64)),
    'noise': st.integers(0, 2**32 - 1),
    'level': st.integers(0, 255),
    'cut': st.integers(0, 300),
})
INFO = _one_of(HEADER | {
    'width': U32,
    'height': U32,
    'distortion_model': st.sampled_from(MODELS) | st.text(max_size=60),
    'd': st.lists(NUMBER, max_size=15),
    'small d': st.tuples(
        st.sampled_from(MODELS),
        st.sampled_from((0, 4, 5, 8, 12, 14)).flatmap(
            lambda n: st.lists(st.floats(-1.0, 1.0), min_size=n, max_size=n)
        ),
    ),
    'k': st.tuples(st.integers(0, 8), NUMBER),
    'r': st.tuples(st.integers(0, 8), NUMBER),
    'p': st.tuples(st.integers(0, 11), NUMBER),
    'binning_x': U32,
    'binning_y': U32,
    'x_offset': U32,
    'y_offset': U32,
    'roi width': U32,
    'roi height': U32,
    'missing': st.none(),
    'cut': st.integers(0, 300),
})
# A calibration of finite numbers, but of no lens.
LENS = st.tuples(
    st.sampled_from((0, 1, 2, 4, 5)),
    st.sampled_from((5e-324, 1e-300, 1e-30, 0.1, 600.0, 1e30, 1e300, -1.0)) | st.floats(),
).map(lambda k: ('k', k))
# Changes of the image, of its camera_info, and of both: a pair whose stamps differ is none. Many
# are as they should be, for what is wrong to have something to spoil.
NONE = st.just(())
PAIR = st.one_of(
    st.tuples(NONE, NONE, NONE),
    st.tuples(st.lists(IMAGE, max_size=2), NONE, NONE),
    st.tuples(NONE, st.lists(INFO, max_size=2), NONE),
    st.tuples(NONE, st.lists(LENS, min_size=1, max_size=3), NONE),
    st.tuples(NONE, NONE, st.lists(_one_of(HEADER), min_size=1, max_size=1)),
    st.tuples(st.lists(IMAGE, max_size=2), st.lists(INFO, max_size=2), NONE),
)
PIXELS = {'data', 'noise', 'level'}  # what changes them
RESHAPED = {'encoding', 'width', 'height', 'step_bytes', 'is_bigendian'}
NOISE = st.tuples(NUMBER, NUMBER, NUMBER)
# What few would be of by chance: stamps that run over, and matrices that divide by nothing.
KNOWN = [
    ((), (), [('stamp', (2**31 - 1, 2**32 - 1))]),
    ((), (), [('stamp', (0, 10**9))]),
    ((), [('k', (0, 5e-324)), ('k', (1, 1e-300)), ('k', (4, 1e-158))], ()),
    ((), [('k', (0, 1e300)), ('k', (4, 1e300))], ()),
]


def _spoil(
    image: Image, info: CameraInfo, changes: Any
) -> tuple[Image | bytes, CameraInfo | bytes | None]:
    """Return a pair with the changes in it; bytes where a message is cut off."""
    of_image, of_info, of_both = changes
    for name, value in of_both:
        _set(image, name, value)
        _set(info, name, value)
    cut: dict[int, int] = {}
    for message, own in ((image, of_image), (info, of_info)):
        for name, value in own:
            if name == 'cut':
                cut[id(message)] = value
            elif name != 'missing':
                _set(message, name, value)
    image_sent, info_sent = (
        serialize_message(each)[:4 + cut[id(each)]] if id(each) in cut else each
        for each in (image, info)
    )
    return image_sent, None if ('missing', None) in of_info else info_sent


def _set(message: Any, name: str, value: Any) -> None:
    """Change one thing of a message."""
    if name == 'frame_id':
        message.header.frame_id = value
    elif name == 'stamp':
        message.header.stamp.sec, message.header.stamp.nanosec = value
    elif name == 'step':
        sec, nanosec = divmod(to_ns(message.header.stamp) + value, 10**9)
        message.header.stamp.sec, message.header.stamp.nanosec = sec, nanosec
    elif name == 'step_bytes':
        message.step = value
    elif name == 'data':
        message.data = array('B', bytes(value))
    elif name == 'noise':
        random = np.random.Generator(np.random.SFC64(value))
        message.data = array('B', random.bytes(len(message.data)))
    elif name == 'level':
        message.data = array('B', [value]) * len(message.data)
    elif name == 'small d':
        message.distortion_model, message.d = value
    elif name in ('k', 'r', 'p'):
        getattr(message, name)[value[0]] = value[1]
    elif name in ('x_offset', 'y_offset') or name.startswith('roi '):
        setattr(message.roi, name.removeprefix('roi '), value)
    else:
        setattr(message, name, value)


def _spoilt(changes: Any, fields: Collection[str] = PIXELS) -> bool:
    """Tell whether the pixels are no longer those of the scene."""
    return any(name in fields for name, _ in changes[0])


class Garbage:
    """Publish garbage to running nodes, and look at what comes of it."""

    def __init__(self, camera: PlayedCamera, processes: list[Process]) -> None:
        self.camera = camera
        self.processes = processes
        self.sent = 0
        self.batches = 0
        self._indices = count(1)
        camera.discover()

    def batch(self, changes: Any) -> None:
        """Publish a batch of pairs; now and then look whether good ones are tracked."""
        camera = self.camera
        for each in changes:
            index = next(self._indices)
            image, info = camera.messages(index)
            spoilt_image, spoilt_info = _spoil(image, info, each)
            place = None if _spoilt(each) else camera.place(index)
            camera.note(to_ns(image.header.stamp), Sent(place, info))
            camera.images.publish(spoilt_image)
            if spoilt_info is not None:
                camera.infos.publish(spoilt_info)
            self.sent += 2
        camera.node.spin(TAKE)
        self.batches += 1
        if self.batches % GOOD == 0:
            self.expect_life()

    def expect_life(self) -> None:
        """Expect living nodes, right bearings of good frames, and none wrong before."""
        assert all(each.running for each in self.processes)
        self.camera.flash()
        self.camera.expect_right()


def _deep(topic: str) -> dict[str, object]:
    """Return parameters that make a subscription deep and reliable."""
    name = f'qos_overrides.{topic}.subscription'
    return {f'{name}.reliability': 'reliable', f'{name}.depth': DEEP.depth}


@pytest.fixture(params=['three processes', 'pipeline'])
def garbage(request: pytest.FixtureRequest, domain: int) -> Iterator[Garbage]:
    """Start the nodes; surviving everything, one after the other, is the test."""
    deep = _deep('/camera/image_raw') | _deep('/camera/camera_info')
    deep_windows = _deep('/target/window/image_raw') | _deep('/target/window/camera_info')
    with ExitStack() as stack:
        node = stack.enter_context(probe(domain))
        if request.param == 'pipeline':
            names = [('pipeline', deep | {'source': 'images'})]
        else:
            names = [('segmenter', deep), ('locator', deep_windows)]
        processes = [stack.enter_context(start(name, domain, **more)) for name, more in names]
        yield Garbage(PlayedCamera(node, SCENE, qos=DEEP), processes)
        for process in processes:
            assert process.end() == 0
            assert 'Traceback' not in process.output


SETTINGS = settings(
    max_examples=BATCHES,
    derandomize=True,
    database=None,
    deadline=None,
    # No shrinking: the nodes remember what was before, and no batch can be tried by itself.
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=list(HealthCheck),
)


def test_garbage_on_the_topics_of_a_camera(garbage: Garbage) -> None:
    """Each field of Image and CameraInfo, out of all bounds."""

    @SETTINGS
    @given(st.lists(PAIR, min_size=PAIRS, max_size=PAIRS))
    @example(KNOWN)
    def send(changes: Any) -> None:
        garbage.batch(changes)

    send()
    garbage.expect_life()
    assert garbage.sent >= 2 * BATCHES * PAIRS


def test_garbage_on_the_topics_of_a_segmenter(domain: int) -> None:
    """Windows and noise that the segmenter never sent, to the locator."""
    deep = _deep('/target/window/image_raw') | _deep('/target/window/camera_info')
    # The windows of the segmenter go through the test: of two publishers none would be heeded.
    aside = ('image_raw', 'camera_info')
    remaps = [word for name in aside for word in ('-r', f'target/window/{name}:=seen/{name}')]
    with (
        probe(domain) as node,
        start('segmenter', domain, *remaps) as segmenter,
        start('locator', domain, **deep) as locator,
    ):
        camera = PlayedCamera(node, SCENE)
        windows = node.record(Image, 'seen/image_raw')
        infos = node.record(CameraInfo, 'seen/camera_info')
        images = node.create_publisher(Image, 'target/window/image_raw', DEEP)
        camera_infos = node.create_publisher(CameraInfo, 'target/window/camera_info', DEEP)
        node.create_subscription(Image, 'seen/image_raw', images.publish, 100)
        node.create_subscription(CameraInfo, 'seen/camera_info', camera_infos.publish, 100)
        garbage = Garbage(camera, [segmenter, locator])
        camera.flash()
        node.spin_until(lambda: _pair(windows, infos))
        window, info = _pair(windows, infos)
        truth = camera.sent[to_ns(window.header.stamp)][0].place
        place = truth[0] - info.roi.x_offset, truth[1] - info.roi.y_offset
        raw_window, raw_info = serialize_message(window), serialize_message(info)
        noises = node.create_publisher(Vector3Stamped, 'target/noise', STATE)

        @settings(SETTINGS, max_examples=BATCHES // 3)
        @given(st.lists(st.tuples(PAIR, NOISE), min_size=PAIRS, max_size=PAIRS))
        @example([(each, (5e-324, 1e300, nan)) for each in KNOWN])
        def send(batch: Any) -> None:
            for changes, noise in batch:
                camera.stamp_ns += STEP_NS
                image = deserialize_message(raw_window, Image)
                camera_info = deserialize_message(raw_info, CameraInfo)
                for message in (image, camera_info):
                    message.header.stamp = from_ns(camera.stamp_ns)
                spoilt_image, spoilt_info = _spoil(image, camera_info, changes)
                stamp_ns = to_ns(image.header.stamp)
                # What other pixels hold, at another width say, is no fault of the locator's.
                if _spoilt(changes, PIXELS | RESHAPED):
                    camera.unknown.add(stamp_ns)
                camera.note(stamp_ns, Sent(place, camera_info))
                images.publish(spoilt_image)
                if spoilt_info is not None:
                    camera_infos.publish(spoilt_info)
                x, y, z = noise
                noises.publish(Vector3Stamped(vector=Vector3(x=x, y=y, z=z)))
            node.spin(TAKE)

        assert node.set_parameter('locator', 'noise.online', True).successful
        send()
        assert node.set_parameter('locator', 'noise.online', False).successful
        garbage.expect_life()
        for process in (segmenter, locator):
            assert process.end() == 0
            assert 'Traceback' not in process.output


# One thing that is wrong with a ray, with a sample of the gyro, with angles of joints.
RAY = _one_of(HEADER | {
    'orientation': st.tuples(st.sampled_from('xyzw'), NUMBER),
    'turn': st.tuples(*4 * [st.floats(-1.0, 1.0)]),
    'covariance': st.tuples(st.sampled_from((21, 22, 27, 28)), NUMBER),
})
GYRO = _one_of(HEADER | {
    'rate': st.tuples(NUMBER, NUMBER, NUMBER),
    'gyro covariance': st.tuples(st.integers(0, 8), NUMBER | st.just(-1.0)),
})
JOINTS = _one_of(HEADER | {
    'name': st.lists(st.sampled_from(('pan', 'tilt')) | st.text(max_size=40), max_size=4),
    'position': st.lists(NUMBER, max_size=4),
})
SAMPLE = st.tuples(
    *(st.lists(each, max_size=2) for each in (RAY, GYRO, JOINTS))
)


def _spoil_sample(message: Any, changes: Any) -> Any:
    """Return a message of a tracker's with the changes in it; bytes where it is cut off."""
    cut = None
    for name, value in changes:
        if name == 'orientation':
            setattr(message.pose.pose.orientation, *value)
        elif name == 'turn':
            length = float(np.linalg.norm(value)) or 1.0
            for axis, part in zip('xyzw', value):
                setattr(message.pose.pose.orientation, axis, part / length)
        elif name == 'covariance':
            message.pose.covariance[value[0]] = value[1]
        elif name == 'rate':
            for axis, part in zip('xyz', value):
                setattr(message.angular_velocity, axis, part)
        elif name == 'gyro covariance':
            message.angular_velocity_covariance[value[0]] = value[1]
        elif name == 'cut':
            cut = value
        else:
            _set(message, name, value)
    return message if cut is None else serialize_message(message)[:4 + cut]


@pytest.mark.parametrize('model', ['constant_velocity', 'constant_acceleration'])
def test_garbage_on_the_topics_of_a_tracker(model: str, domain: int) -> None:
    """Rays, rates and joints that nobody ever sent: what is predicted is an angle, or nothing."""
    parameters = {'imu.enabled': True, 'joints.pan': 'pan', 'joints.tilt': 'tilt', 'model': model}
    for topic in ('/target/ray', '/imu', '/joint_states'):
        parameters |= _deep(topic)
    with probe(domain) as node, start('tracker', domain, **parameters) as tracker:
        predictions = node.record(Vector3Stamped, 'target/bearing_predicted', DEEP)
        tracks = node.record(Odometry, 'target/track', DEEP)
        rays, gyro, joints = (
            node.create_publisher(kind, topic, DEEP)
            for kind, topic in (
                (PoseWithCovarianceStamped, 'target/ray'), (Imu, 'imu'),
                (JointState, 'joint_states'),
            )
        )
        node.spin_until(lambda: all(
            each.get_subscription_count() for each in (rays, gyro, joints)
        ))

        def send(ray_changes: Any, gyro_changes: Any, joint_changes: Any) -> None:
            stamp_ns = node.get_clock().now().nanoseconds
            ray = ray_message(Bearing(100.0, -50.0, 1e-4 * np.eye(2), stamp_ns), 'optical')
            imu, states = Imu(), JointState(name=['pan', 'tilt'], position=[0.2, 0.1])
            for message in (imu, states):
                message.header.stamp = from_ns(stamp_ns)
            imu.header.frame_id = 'imu_link'
            gyro.publish(_spoil_sample(imu, gyro_changes))
            joints.publish(_spoil_sample(states, joint_changes))
            rays.publish(_spoil_sample(ray, ray_changes))

        def expect_life() -> None:
            """Expect a target at rest to be predicted where it is, once the filter sees it."""
            assert tracker.running, (tracker.wait(), tracker.output)
            for _ in range(40):
                send((), (), ())
                node.spin(0.03)
            predictions.clear()
            send((), (), ())
            node.spin_until(lambda: predictions)
            x, y = predictions[-1].vector.x, predictions[-1].vector.y
            # As R_y(0.2) R_x(0.1) has it, to what is left of the last leap.
            assert abs(x - 299.6) < 5.0 and abs(y - 49.6) < 5.0

        @settings(SETTINGS, max_examples=BATCHES // 2)
        @given(st.lists(SAMPLE, min_size=PAIRS, max_size=PAIRS))
        def batch(samples: Any) -> None:
            for sample in samples:
                send(*sample)
            node.spin(TAKE)

        expect_life()
        for _ in range(2):
            batch()
            expect_life()
        # A few: the middleware says a paragraph of each, and nobody reads it before the end.
        for cut in range(0, 300, 20):
            send(*(3 * [[('cut', cut)]]))
        expect_life()
        for each in predictions:
            assert abs(each.vector.x) <= 1e3 * pi and abs(each.vector.y) <= 500.0 * pi
        for each in tracks:
            to_track(each)
        assert tracker.end() == 0
        assert 'Traceback' not in tracker.output, tracker.output


def _pair(images: list[Image], infos: list[CameraInfo]) -> tuple[Image, CameraInfo] | None:
    """Return the last of both that have one stamp; None where there are none."""
    by_stamp = {to_ns(info.header.stamp): info for info in infos}
    for image in reversed(images):
        if to_ns(image.header.stamp) in by_stamp:
            return image, by_stamp[to_ns(image.header.stamp)]
    return None
