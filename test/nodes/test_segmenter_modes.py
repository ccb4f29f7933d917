"""The segmenter node in its flash modes: topics for each light, and refusals in a sentence."""

from __future__ import annotations

from blob_tracker.camera import CameraModel
from blob_tracker.ros.camera_info import from_camera_model, stamped
from blob_tracker.ros.image import from_pixels
from blob_tracker.ros.qos import IMAGE_OUT, STATE
from blob_tracker.ros.stamp import to_ns
from blob_tracker.simulation import coded, Light, periodic, Scene
from processes import PATIENCE, probe, start
import pytest
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Bool

RATE = 60.0
MODEL = CameraModel.from_field_of_view(160, 120, 40.0)
CODES = {'port': '1101000', 'starboard': '1111010'}


def before_a_wall(*lights: Light, exposure: float = 0.5) -> Scene:
    """Return a scene of these lights."""
    return Scene(
        elements=lights, width=160, height=120, rate=RATE, exposure=exposure, texture=0.0
    )


def play(node, scene: Scene, until) -> None:
    """Publish the frames of a scene until something has come of them."""
    images = node.create_publisher(Image, 'camera/image_raw', IMAGE_OUT)
    infos = node.create_publisher(CameraInfo, 'camera/camera_info', IMAGE_OUT)
    index = 0

    def step() -> bool:
        nonlocal index
        stamp_ns = scene.stamp_ns(index)
        images.publish(from_pixels(scene.frame(index), stamp_ns, 'optical'))
        infos.publish(stamped(from_camera_model(MODEL, 160, 120), stamp_ns, 'optical'))
        index += 1
        return until()

    node.spin_until(step)


def test_each_coded_light_has_topics_of_its_own(domain: int) -> None:
    """Windows at the light's place, with their camera_info, and visible, under its name."""
    places = {'port': (40, 30), 'starboard': (110, 80)}
    scene = before_a_wall(*(
        Light(*places[name], 2.0, 120.0, coded(bits, 1 / RATE, start=0.5 / RATE))
        for name, bits in CODES.items()
    ), exposure=0.3)
    codes = ','.join(f'{name}:{bits}' for name, bits in CODES.items())
    with probe(domain) as node:
        windows = {name: node.record(Image, f'target/{name}/window/image_raw') for name in CODES}
        infos = {
            name: node.record(CameraInfo, f'target/{name}/window/camera_info') for name in CODES
        }
        visible = {name: node.record(Bool, f'target/{name}/visible', STATE) for name in CODES}
        with start('segmenter', domain, flash__mode='coded', flash__codes=codes):
            play(node, scene, lambda: all(len(windows[name]) >= 4 for name in CODES))
            node.spin(0.3)
    for name, (x, y) in places.items():
        assert visible[name][-1].data is True
        assert {m.encoding for m in windows[name]} == {'8UC2'}
        for info in infos[name]:
            assert abs(info.roi.x_offset + (info.roi.width - 1) / 2 - x) <= 1.5
            assert abs(info.roi.y_offset + (info.roi.height - 1) / 2 - y) <= 1.5


def test_periodic_windows_are_sums_of_16_bits(domain: int) -> None:
    """16UC2, with a camera_info of the same stamp, though that is no frame's own."""
    scene = before_a_wall(Light(71.3, 52.6, 2.0, 60.0, periodic(0.31 * RATE, 0.5)))
    with probe(domain) as node:
        windows = node.record(Image, 'target/window/image_raw')
        infos = node.record(CameraInfo, 'target/window/camera_info')
        with start(
            'segmenter', domain, flash__mode='periodic', flash__frequency=0.31 * RATE
        ):
            play(node, scene, lambda: len(windows) >= 2 and len(infos) >= 2)
    assert {m.encoding for m in windows} == {'16UC2'}
    assert {to_ns(m.header.stamp) for m in windows} & {to_ns(m.header.stamp) for m in infos}


def test_steady_windows_have_one_channel(domain: int) -> None:
    """8UC1, from single frames."""
    scene = before_a_wall(Light(71.3, 52.6, 2.0, 60.0))
    with probe(domain) as node:
        windows = node.record(Image, 'target/window/image_raw')
        with start('segmenter', domain, flash__mode='steady'):
            play(node, scene, lambda: len(windows) >= 2)
    assert {m.encoding for m in windows} == {'8UC1'}


@pytest.mark.parametrize('parameters, sentence', [
    ({'flash__mode': 'disco'}, "'flash.mode' is 'disco'; it must be one of alternate"),
    ({'flash__mode': 'coded'}, 'there is no code'),
    ({'flash__codes': 'a:1100,a:1010'}, "two codes are called 'a'"),
    ({'flash__mode': 'coded', 'flash__codes': 'a:1100,b:0110'}, "'a' and 'b' differ by 0 bits"),
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
