"""The segmenter node in its flash modes: topics for each light, and refusals in a sentence."""

from __future__ import annotations

from collections.abc import Callable
import itertools
from pathlib import Path
import time

from blob_tracker.camera import CameraModel
from blob_tracker.ros.endpoints.qos import IMAGE_OUT, STATE
from blob_tracker.ros.messages.camera_info import from_camera_model, stamped
from blob_tracker.ros.messages.image import from_pixels
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.simulation import coded, in_step, Light, periodic, Scene, Sensor
from blob_tracker.types import SensorNoise
import cv2
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped
import numpy as np
import pytest
from rcl_interfaces.msg import Log
from scipy.stats import chi2
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Bool
from support.processes import PATIENCE, Probe, probe, start
from support.slowness import slowness

RATE = 60.0
MODEL = CameraModel.from_field_of_view(160, 120, 40.0)
CODES = {'port': '1101000', 'starboard': '1111010'}


def before_a_wall(
    *lights: Light, exposure: float = 0.5, read_noise: float = 0.7, bits: int = 8
) -> Scene:
    """Return a scene of these lights."""
    return Scene(
        elements=lights,
        width=160,
        height=120,
        rate=RATE,
        exposure=exposure,
        texture=0.0,
        sensor=Sensor(SensorNoise(gain=40.0, read_noise=read_noise), bits),
    )


class Camera:
    """Frames that the test plays; what comes of them is waited for, however many are lost."""

    def __init__(self, node: Probe) -> None:
        self._node = node
        self._images = node.create_publisher(Image, 'camera/image_raw', IMAGE_OUT)
        self._infos = node.create_publisher(CameraInfo, 'camera/camera_info', IMAGE_OUT)
        self._info = from_camera_model(MODEL, 160, 120)
        self._diagnostics = node.record(DiagnosticArray, '/diagnostics')

    def play(self, scene: Scene, until: Callable[[], object], first: int = 0) -> int:
        """Publish frames until something has come of them; return the next one's number."""
        began = time.monotonic()
        for index in itertools.count(first):
            stamp_ns = scene.stamp_ns(index)
            self._images.publish(from_pixels(scene.frame(index), stamp_ns, 'optical'))
            self._infos.publish(stamped(self._info, stamp_ns, 'optical'))
            self._node.spin(0.01)
            if until():
                return index + 1
            waited = time.monotonic() - began
            assert waited < PATIENCE * slowness(), self._state(index + 1 - first, waited)
        raise AssertionError

    def _state(self, sent: int, waited: float) -> str:
        """Say what there was where nothing came."""
        takers = self._images.get_subscription_count(), self._infos.get_subscription_count()
        return (
            f'not within {waited:.0f} s: {sent} frames; taken by {takers}; there are '
            f'{self._node.get_node_names()}; said is '
            f'{[each.status[0] for each in self._diagnostics[-2:]]}'
        )


def alternate(x: float, y: float, amplitude: float) -> Light:
    """Return a light that is on in every other frame."""
    return Light(x, y, 2.0, amplitude, in_step(RATE))


def values(diagnostics: list[DiagnosticArray]) -> dict[str, str]:
    """Return the values of the segmenter's last diagnostics; empty where there are none."""
    said = [a.status[0] for a in diagnostics if a.status[0].name.startswith('/segmenter')]
    return {pair.key: pair.value for pair in said[-1].values} if said else {}


def test_each_coded_light_has_topics_of_its_own(domain: int) -> None:
    """Windows at the light's place, with their camera_info, and visible, under its name."""
    places = {'port': (40, 30), 'starboard': (110, 80)}
    scene = before_a_wall(*(
        Light(*places[name], 2.0, 120.0, coded(bits, 1 / RATE, start=0.5 / RATE))
        for name, bits in CODES.items()
    ), exposure=0.3)
    codes = ','.join(f'{name}:{bits}' for name, bits in CODES.items())
    with probe(domain) as node:
        camera = Camera(node)
        windows = {name: node.record(Image, f'target/{name}/window/image_raw') for name in CODES}
        infos = {
            name: node.record(CameraInfo, f'target/{name}/window/camera_info') for name in CODES
        }
        visible = {name: node.record(Bool, f'target/{name}/visible', STATE) for name in CODES}
        with start(
            'segmenter', domain, flash__mode='coded', flash__codes=codes,
            flash__exposure=0.3 / RATE,
        ):
            camera.play(scene, lambda: all(len(windows[name]) >= 4 for name in CODES))
            node.spin_until(
                lambda: all(visible[name] and visible[name][-1].data for name in CODES)
            )
            # The camera has stopped: no light is in view any more.
            node.spin_until(lambda: not any(visible[name][-1].data for name in CODES))
    for name, (x, y) in places.items():
        assert {m.encoding for m in windows[name]} == {'8UC4'}  # with how it was seen
        for info in infos[name]:
            assert abs(info.roi.x_offset + (info.roi.width - 1) / 2 - x) <= 1.5
            assert abs(info.roi.y_offset + (info.roi.height - 1) / 2 - y) <= 1.5


def test_windows_of_lock_in_are_sums_of_16_bits(domain: int) -> None:
    """16UC2, with a camera_info of the same stamp, though that is no frame's own."""
    scene = before_a_wall(Light(71.3, 52.6, 2.0, 60.0, periodic(0.31 * RATE, 0.5)))
    with probe(domain) as node:
        camera = Camera(node)
        windows = node.record(Image, 'target/window/image_raw')
        infos = node.record(CameraInfo, 'target/window/camera_info')
        visible = node.record(Bool, 'target/visible', STATE)
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        with start(
            'segmenter', domain, flash__mode='lock_in', flash__frequency=0.31 * RATE
        ):
            camera.play(scene, lambda: len(windows) >= 3 and len(infos) >= 3)
            # From the first block on it is in view, also while the next one is gathered.
            assert [m.data for m in visible][-1] is True
            assert [m.data for m in visible].count(True) == 1
            node.spin_until(lambda: 'frames summed in a window' in values(diagnostics))
    # Of 16 frames half are lit; one may be cut by an edge.
    assert values(diagnostics)['frames summed in a window'] == '7'
    assert {m.encoding for m in windows} == {'16UC2'}
    assert {to_ns(m.header.stamp) for m in windows} & {to_ns(m.header.stamp) for m in infos}


def test_auto_says_which_light_it_found(domain: int) -> None:
    """It watches, says so, then publishes the window of the light and what to set."""
    scene = before_a_wall(Light(71.3, 52.6, 2.0, 120.0, periodic(10.3, 0.5)))
    with probe(domain) as node:
        camera = Camera(node)
        windows = node.record(Image, 'target/window/image_raw')
        diagnostics = node.record(DiagnosticArray, '/diagnostics')

        def watching() -> bool:
            return any(
                status.message.startswith('no target: watching what blinks')
                for array in diagnostics for status in array.status
            )

        with start('segmenter', domain, flash__mode='auto', flash__exposure=0.5 / RATE):
            # Diagnostics come once a second, and a light that blinks is found in less.
            first = camera.play(before_a_wall(), watching)
            camera.play(
                scene, lambda: 'light found' in values(diagnostics) and len(windows) > 5,
                first=first,
            )
    assert 'set flash.mode periodic, flash.frequency 10.' in values(diagnostics)['light found']


def test_a_light_out_of_step_is_spoken_of_in_the_log(domain: int) -> None:
    """Why it is no target, after some seconds, and which parameter takes it."""
    scene = before_a_wall(Light(71.3, 52.6, 2.0, 120.0, periodic(8.1, 0.5)))
    with probe(domain) as node:
        camera = Camera(node)
        said = node.record(Log, '/rosout')
        with start('segmenter', domain):
            camera.play(
                scene, lambda: any('flash.mode, such as auto' in each.msg for each in said),
            )
    assert any(each.msg.startswith('no target: ') for each in said)


def test_steady_windows_have_one_channel(domain: int) -> None:
    """8UC1, from single frames."""
    scene = before_a_wall(Light(71.3, 52.6, 2.0, 60.0))
    with probe(domain) as node:
        camera = Camera(node)
        windows = node.record(Image, 'target/window/image_raw')
        with start('segmenter', domain, flash__mode='steady'):
            camera.play(scene, lambda: len(windows) >= 2)
    assert {m.encoding for m in windows} == {'8UC1'}


def test_the_covariance_of_summed_looks_is_true(domain: int) -> None:
    """Segmenter and locator with 5 looks: the NEES of bearings whose noise is read noise."""
    place = np.array([71.3, 52.6])
    scene = before_a_wall(alternate(place[0], place[1], 60.0), read_noise=3.0)
    # Of the methods this one takes the noise as it is told: maximum_likelihood would see from its
    # residuals that there is more.
    locator = {'method': 'multi_gaussian_lm', 'noise__gain': 40.0, 'noise__read_noise': 3.0}
    with probe(domain) as node:
        camera = Camera(node)
        windows = node.record(Image, 'target/window/image_raw')
        centroids = node.record(PointStamped, 'target/centroid')
        rays = node.record(PoseWithCovarianceStamped, 'target/ray')
        with (
            start('segmenter', domain, looks=5),
            start('locator', domain, looks=5, **locator),
        ):
            camera.play(scene, lambda: min(len(rays), len(centroids)) >= 40)
    assert {m.encoding for m in windows} == {'16UC2'}
    covariance = {to_ns(m.header.stamp): m.pose.covariance for m in rays}
    focal_length = MODEL.matrix[0, 0]
    squares = []
    for message in centroids:
        if to_ns(message.header.stamp) in covariance:
            error = (np.array([message.point.x, message.point.y]) - place) / focal_length
            # About y is azimuth, about x elevation; within a few degrees of the axis and so few
            # hundredths of their correlation they are the errors along x and y in rad.
            variance = np.array(covariance[to_ns(message.header.stamp)])[[28, 21]]
            squares.append(float((error**2 / variance).sum()))
    assert len(squares) >= 35
    # One run in a million is outside; the read noise of one frame would make it 5 times 2.
    low, high = chi2.ppf([5e-7, 1 - 5e-7], 2 * len(squares)) / len(squares)
    assert low < np.mean(squares) < high


def test_a_mask_hides_the_brighter_light(domain: int, tmp_path: Path) -> None:
    """White about the fainter one; of another size it is an ERROR and no window comes."""
    scene = before_a_wall(alternate(40, 30, 150.0), alternate(110, 80, 80.0))
    mask = np.zeros((120, 160), np.uint8)
    mask[60:100, 90:130] = 255
    cv2.imwrite(str(tmp_path / 'mask.png'), mask)
    cv2.imwrite(str(tmp_path / 'small.png'), mask[60:])
    with probe(domain) as node:
        camera = Camera(node)
        infos = node.record(CameraInfo, 'target/window/camera_info')
        with start('segmenter', domain, mask_url=tmp_path / 'mask.png'):
            camera.play(scene, lambda: len(infos) >= 5)
        for info in infos:
            assert abs(info.roi.x_offset + (info.roi.width - 1) / 2 - 110) <= 1.5
        node.spin_until(lambda: 'segmenter' not in node.get_node_names())
        infos.clear()
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        sentence = 'the mask is 160 x 60 px and the frame 160 x 120'
        with start('segmenter', domain, mask_url=f'file://{tmp_path}/small.png'):
            camera.play(scene, lambda: any(sentence in a.status[0].message for a in diagnostics))
        assert not infos


def test_the_debug_image_and_the_diagnostics_show_the_look(domain: int) -> None:
    """A picture for whoever subscribes; state, candidates and noise for all."""
    scene = before_a_wall(alternate(71.3, 52.6, 60.0))
    with probe(domain) as node:
        camera = Camera(node)
        windows = node.record(Image, 'target/window/image_raw')
        pictures = node.record(Image, 'segmenter/debug_image')
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        with start('segmenter', domain):
            camera.play(scene, lambda: len(windows) >= 8 and len(pictures) >= 2)
            node.spin_until(lambda: 'strongest of them' in values(diagnostics))
    assert {m.encoding for m in pictures} == {'bgr8'}
    assert all(m.width >= 900 and len(m.data) == m.height * m.step for m in pictures)
    shown = values(diagnostics)
    assert shown['flash lock'] in ('locked', 'lost')
    assert shown['strongest of them'].endswith('at (71, 53): may be the target')
    # Two frames of 0.7 DN read noise, 1 DN shot noise and rounding; three digits are for people.
    assert 1.2 < float(shown['noise (DN)']) < 2.2


def test_more_looks_than_16_bits_hold_are_named(domain: int) -> None:
    """A camera of 16 bits whose full scale is not said."""
    scene = before_a_wall(alternate(71.3, 52.6, 600.0), bits=12)
    with probe(domain) as node:
        camera = Camera(node)
        windows = node.record(Image, 'target/window/image_raw')
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        sentence = '5 frames of up to 65535 DN do not fit'
        with start('segmenter', domain, looks=5):
            camera.play(scene, lambda: any(sentence in a.status[0].message for a in diagnostics))
        assert not windows
        node.spin_until(lambda: 'segmenter' not in node.get_node_names())
        with start('segmenter', domain, looks=5, saturation=4095):
            camera.play(scene, lambda: windows)
    assert windows[0].encoding == '16UC2'


@pytest.mark.parametrize('parameters, sentence', [
    ({'mask_url': '/no/mask.png'}, "'mask_url': there is no file /no/mask.png"),
    ({'mask_url': __file__}, 'test_segmenter_modes.py is not an image'),
    ({'looks': 0}, "'looks' is 0; it must be an integer from 1 to 256"),
    ({'flash__mode': 'disco'}, "'flash.mode' is 'disco'; it must be one of alternate"),
    ({'flash__mode': 'coded'}, 'there is no light'),
    ({'flash__codes': 'a:1100,a:1010'}, "two codes are called 'a'"),
    ({'flash__mode': 'coded', 'flash__codes': 'a:1100,b:0110'}, 'one code begun at another bit'),
    ({'flash__codes': '1101000'}, "'flash.codes' is 1101000; it must be a string"),
    ({'flash__codes': '00010111'}, 'put it in quotes'),
    ({'flash__codes': 'a,b'}, "'a' is not a light; write its name before it"),
    ({'flash__mode': 'periodic', 'flash__frequencies': 'a:6,b:6.01'}, 'clocks are off by 1 %'),
    ({'threshold__method': 'best'}, "'threshold.method' is 'best'; it must be one of sigma"),
])
def test_impossible_parameters_end_with_a_sentence(
    parameters: dict[str, object], sentence: str, domain: int
) -> None:
    """Exit code 2, and what is wrong."""
    with start('segmenter', domain, **parameters) as process:
        assert process.wait(PATIENCE) == 2
    assert sentence in process.output
    assert 'Traceback' not in process.output
