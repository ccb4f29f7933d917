"""What reaches the nodes from a broken camera: one clear message, silence, and a living node."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator
from itertools import count, cycle
from math import nan

from blob_tracker.camera import CameraModel
from blob_tracker.resources import config_path
from blob_tracker.ros.endpoints.qos import STATE
from blob_tracker.ros.messages.camera_info import from_camera_model, stamped
from blob_tracker.ros.messages.image import from_pixels
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.simulation import flashing_light, Scene
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Vector3Stamped
import numpy as np
import pytest
from rclpy.qos import QoSProfile
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Bool
from support.processes import Probe, probe, Process, start

SCENE = flashing_light(width=160, height=120, period=3.0)
MODEL = CameraModel.from_field_of_view(160, 120, 40.0)
STEP_NS = 16_666_667
_NOW = 10**18
# The nodes take all in their time: nothing is lost in a queue where the machine is busy, that
# would be a fault of its own.
DEEP = QoSProfile(depth=2000)
NOISE = np.random.default_rng(6)


class Tracker:
    """Segmenter and locator, and a camera that the test plays."""

    def __init__(self, node: Probe, processes: list[Process]) -> None:
        self.node = node
        self.processes = processes
        self._bearings = node.record(Vector3Stamped, 'target/bearing')
        self.begin_ns = -1
        self.visible = node.record(Bool, 'target/visible', STATE)
        self.diagnostics = node.record(DiagnosticArray, '/diagnostics')
        self._images = node.create_publisher(Image, 'camera/image_raw', DEEP)
        self._infos = node.create_publisher(CameraInfo, 'camera/camera_info', DEEP)
        self.stamp_ns = _NOW
        self.flash()

    @property
    def bearings(self) -> list[Vector3Stamped]:
        """Bearings of the frames that this test has sent, not of one before."""
        return [b for b in self._bearings if to_ns(b.header.stamp) > self.begin_ns]

    def send(
        self,
        index: int,
        change_image: Callable[[Image], None] = lambda image: None,
        change_info: Callable[[CameraInfo], None] | None = lambda info: None,
        step_ns: int = STEP_NS,
        scene: Scene = SCENE,
    ) -> None:
        """Publish a frame of the scene with something changed; no camera_info for None."""
        self.stamp_ns += step_ns
        image = from_pixels(scene.frame(index), self.stamp_ns, 'optical')
        info = from_camera_model(
            MODEL if scene is SCENE else CameraModel.from_field_of_view(
                scene.width, scene.height, 40.0
            ),
            scene.width,
            scene.height,
        )
        stamped(info, self.stamp_ns, 'optical')
        change_image(image)
        self._images.publish(image)
        if change_info is not None:
            change_info(info)
            self._infos.publish(info)
        self.node.spin(0.01)

    def messages(self, level: bytes) -> list[str]:
        """Return what the diagnostics have said at a level so far."""
        return [a.status[0].message for a in self.diagnostics if a.status[0].level == level]

    def expect(
        self, sentence: str, level: bytes, feed: Callable[[], object] = lambda: None
    ) -> None:
        """Wait until a diagnostic says this, and send meanwhile what it is to be said of."""
        try:
            self.node.spin_until(
                lambda: feed() or any(sentence in each for each in self.messages(level))
            )
        except AssertionError:
            said = [(a.status[0].level, a.status[0].message) for a in self.diagnostics]
            raise AssertionError(f'{sentence!r} is not in {said}') from None

    def expect_life(self) -> None:
        """Expect both nodes to run and a flash pair to give a bearing again."""
        assert all(process.running for process in self.processes)
        self.stamp_ns += 10**9  # nothing pairs with what came before
        self.flash()

    def flash(self, first: int = 1, scene: Scene = SCENE) -> None:
        """
        Send frames from the first on until one of them has a bearing.

        How many flashes it takes to be sure of the target depends on what lit up lately.
        """
        before_ns = self.stamp_ns
        frames = count(first)
        self.node.spin_until(
            lambda: self.send(next(frames), scene=scene) or self.located_after(before_ns))

    def located_after(self, stamp_ns: int) -> bool:
        """Tell whether there is a bearing of after a stamp, ns."""
        return bool(self._bearings) and to_ns(self._bearings[-1].header.stamp) > stamp_ns


def to_and_fro(last: int) -> Iterator[int]:
    """Return numbers of frames without an end: a light that leaps is hardly believed after it."""
    return cycle([*range(1, last + 1), *range(last - 1, 1, -1)])


@pytest.fixture(scope='module')
def running(module_domain: int) -> Iterator[Tracker]:
    """Start the nodes once: surviving everything, one after the other, is the test."""
    patient = ('--params-file', str(config_path('replay.yaml')))
    with (
        probe(module_domain) as node,
        start('segmenter', module_domain, *patient) as segmenter,
        start('locator', module_domain, *patient) as locator,
    ):
        yield Tracker(node, [segmenter, locator])


@pytest.fixture
def tracker(running: Tracker) -> Iterator[Tracker]:
    """Give the running nodes with empty records; they must live and track afterwards."""
    running.begin_ns = running.stamp_ns
    running.diagnostics.clear()
    yield running
    running.expect_life()


def _set(**fields: object) -> Callable[[object], None]:
    """Return a function that sets fields of a message."""

    def change(message: object) -> None:
        for name, value in fields.items():
            setattr(message, name, value)

    return change


def _focal_length(value: float) -> Callable[[CameraInfo], None]:
    """Return a function that sets the focal length."""

    def change(info: CameraInfo) -> None:
        info.k[0] = value

    return change


@pytest.mark.parametrize(
    'change, sentence',
    [
        (_set(encoding='32FC1'), "the encoding is '32FC1'; it must be mono8"),
        (_set(encoding='32FC1', data=array('f', [nan]).tobytes() * 160 * 120, step=640),
         "the encoding is '32FC1'; it must be mono8"),
        (_set(width=0), 'neither may be 0'),
        (_set(height=0), 'neither may be 0'),
        (_set(step=10), 'step is 10 bytes; 160 px of mono8 need 160'),
        (_set(height=119), 'step * height is 160 * 119'),
        (_set(data=b''), 'data has 0 bytes'),
    ],
)
def test_a_broken_image_is_named_and_gives_nothing(
    tracker: Tracker, change: Callable[[Image], None], sentence: str
) -> None:
    """An ERROR with the sentence, and no bearing from any of these frames."""
    frames = count(1)
    tracker.expect(
        sentence, DiagnosticStatus.ERROR, lambda: tracker.send(next(frames), change))
    assert not tracker.bearings


@pytest.mark.parametrize(
    'change, sentence',
    [
        (_focal_length(nan), 'K must be 3 x 3 finite numbers'),
        (_focal_length(0.0), 'not calibrated has 0: set camera_info_url'),
        (_set(distortion_model='fov'), "no distortion model 'fov'"),
        (_set(d=[0.1, nan, 0.0, 0.0, 0.0]), 'distortion coefficients must be finite'),
    ],
)
def test_an_impossible_calibration_is_named_and_gives_nothing(
    tracker: Tracker, change: Callable[[CameraInfo], None], sentence: str
) -> None:
    """The locator says what is wrong with the camera_info."""
    frames = to_and_fro(12)  # flashes enough to be sure of the target
    tracker.expect(
        sentence, DiagnosticStatus.ERROR,
        lambda: tracker.send(next(frames), change_info=change))
    assert not tracker.bearings


def test_images_without_camera_info_are_named(tracker: Tracker) -> None:
    """The missing partner is said, not waited for in silence."""
    frames = to_and_fro(14)
    tracker.expect(
        'without a camera/camera_info of the same stamp', DiagnosticStatus.WARN,
        lambda: tracker.send(next(frames), change_info=None))
    assert not tracker.bearings


def test_repeated_and_old_frames_are_named_and_left_out(tracker: Tracker) -> None:
    """A stamp that does not grow is a WARN; the pair around it still counts."""
    tracker.send(1)
    tracker.send(4, step_ns=0)
    tracker.expect('its stamp is repeated', DiagnosticStatus.WARN)
    tracker.send(6, step_ns=-STEP_NS)
    tracker.stamp_ns += STEP_NS
    tracker.flash(first=2)


def test_frames_that_nobody_stamps_are_named(tracker: Tracker) -> None:
    """All of them have the stamp 0."""
    stamp_ns, tracker.stamp_ns = tracker.stamp_ns, 0
    tracker.expect(
        'its stamp is 0 like that before', DiagnosticStatus.WARN,
        lambda: tracker.send(1, step_ns=0))
    tracker.stamp_ns = stamp_ns
    assert not tracker.bearings


def test_zeros_of_no_distortion_model_are_none(tracker: Tracker) -> None:
    """Some drivers fill them in."""
    frames = to_and_fro(12)
    before_ns = tracker.stamp_ns
    tracker.node.spin_until(lambda: tracker.send(
        next(frames), change_info=_set(distortion_model='', d=[0.0] * 5)
    ) or tracker.located_after(before_ns))


def test_a_change_of_resolution_starts_afresh(tracker: Tracker) -> None:
    """The change is a WARN, and the new size is tracked."""
    scene = flashing_light(width=200, height=150, period=3.0)
    tracker.send(1)
    tracker.send(2, scene=scene)
    tracker.expect('changed from 160 x 120', DiagnosticStatus.WARN)
    tracker.flash(first=3, scene=scene)


def test_a_camera_info_of_another_size_is_named(tracker: Tracker) -> None:
    """The image of one camera with the calibration of another gives no bearing."""
    frames = count(1)
    tracker.expect(
        'its camera_info is for 640 x 480 px', DiagnosticStatus.ERROR,
        lambda: tracker.send(next(frames), change_info=_set(width=640, height=480)))
    assert not tracker.bearings


def test_a_camera_that_stops_turns_visible_false(tracker: Tracker) -> None:
    """No frame at all: false within a second or two, for whoever listens later as well."""
    tracker.flash()
    tracker.node.spin_until(lambda: tracker.visible and tracker.visible[-1].data)
    tracker.node.spin_until(lambda: not tracker.visible[-1].data)


def _filled(level: int) -> Callable[[Image], None]:
    """Return a function that makes an image even."""

    def change(image: Image) -> None:
        image.data = array('B', [level] * len(image.data))

    return change


@pytest.mark.parametrize('change, sentence', [
    (_filled(0), 'no target: the brightest pixel is 0 DN of 255: is the lens cap on?'),
    (_filled(255), 'no target: 100 % of the pixels are clipped at 255 DN'),
])
def test_frames_that_show_nothing_are_named(
    tracker: Tracker, change: Callable[[Image], None], sentence: str
) -> None:
    """The lens cap, or the sun: a WARN, not the silence of a light that is off."""
    frames = count(1)
    tracker.expect(sentence, DiagnosticStatus.WARN, lambda: tracker.send(next(frames), change))
    assert not tracker.bearings


def noisy(image: Image) -> None:
    """Change the last bit of every third pixel or so: no sensor sees the same noise twice."""
    pixels = np.frombuffer(image.data, np.uint8)
    image.data = array('B', (pixels ^ (NOISE.random(pixels.size) < 0.3)).tobytes())


@pytest.mark.parametrize('indices', [
    pytest.param((1, 3, 5, 7), id='never on'),
    pytest.param((2, 2, 2, 2), id='always on'),
])
def test_a_light_that_does_not_flash_is_said_to_be_missing(
    tracker: Tracker, indices: tuple[int, ...]
) -> None:
    """Frames in order that hold nothing to follow: a sentence, and no bearing."""
    tracker.stamp_ns += 10**9
    frames = cycle(indices)
    tracker.expect(
        'no target: nothing lit up', DiagnosticStatus.OK,
        lambda: tracker.send(next(frames), noisy))
    assert not tracker.bearings


def test_frames_that_come_twice_are_named(tracker: Tracker) -> None:
    """A driver that gives the same frame again, and again."""
    tracker.stamp_ns += 10**9
    for index in (1, 3):
        tracker.send(index)
    tracker.expect(
        'the frame is identical to the one before it', DiagnosticStatus.WARN,
        lambda: tracker.send(3))
    assert not tracker.bearings


def test_an_exposure_that_jumps_gives_nothing(tracker: Tracker) -> None:
    """Half as much light again in every other frame, and none of it from a target."""

    def brighter(image: Image) -> None:
        image.data = array('B', [min(level + level // 2, 255) for level in image.data])

    tracker.stamp_ns += 10**9
    frames = count()

    def exposed() -> None:
        index = next(frames)
        tracker.send(2 * index + 1, brighter if index % 2 else lambda image: None)

    tracker.expect('no target: ', DiagnosticStatus.OK, exposed)
    assert not tracker.bearings


def test_a_lost_target_turns_visible_false(tracker: Tracker) -> None:
    """The light stays off: false once, after lost_after; true again when it returns."""
    tracker.flash()
    tracker.node.spin_until(lambda: tracker.visible and tracker.visible[-1].data)
    tracker.visible.clear()
    tracker.expect(
        'no target: nothing lit up', DiagnosticStatus.OK, lambda: tracker.send(1, noisy))
    tracker.node.spin_until(lambda: tracker.visible)
    assert [message.data for message in tracker.visible] == [False]


def test_silence_is_named(tracker: Tracker) -> None:
    """No frame for more than a second: both nodes say what is missing."""
    tracker.expect('is a camera publishing camera/image_raw', DiagnosticStatus.WARN)
    tracker.expect(
        'no window arrives: the segmenter sees no target (its diagnostics say why), or is not '
        'running', DiagnosticStatus.WARN)
