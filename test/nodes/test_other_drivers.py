"""Frames as other drivers send them: any encoding, compressed, with a camera_info or without."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator
import itertools
from pathlib import Path
from typing import Any

from blob_tracker.camera import CameraModel, write_calibration
from blob_tracker.ros.endpoints.qos import IMAGE_OUT
from blob_tracker.ros.messages.camera_info import from_camera_model, stamped
from blob_tracker.ros.messages.stamp import from_ns, to_ns
import cv2
from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from support.filtered_flashes import BACKGROUND, digitised, gaussian, SHAPE, STEP_NS
from support.processes import probe, start

MODEL = CameraModel.from_field_of_view(SHAPE[1], SHAPE[0], 40.0)
FIRST_NS = 10**18
PACKED = {'yuv422': 1, 'uyvy': 1, 'yuv422_yuy2': 0, 'yuyv': 0}  # where the luma is
PLANAR = {'nv12': 0.5, 'nv21': 0.5, 'nv24': 2.0}  # chromas for a luma
ENCODINGS = (
    'mono8', 'mono16', '8UC1', '16UC1', *PACKED, *PLANAR,
    *(f'{name}{bits}' for bits in (8, 16) for name in (
        'bgr', 'rgb', 'bgra', 'rgba', 'bayer_rggb', 'bayer_bggr', 'bayer_gbrg', 'bayer_grbg')),
)


def encoded(grey: np.ndarray, encoding: str, stamp_ns: int) -> Image:
    """Return a white light's image in an encoding."""
    height, width = grey.shape
    if encoding in PACKED:
        pixels: np.ndarray = np.full((height, width, 2), 128, np.uint8)
        pixels[..., PACKED[encoding]] = grey
    elif encoding in PLANAR:
        chromas = np.full((int(height * PLANAR[encoding]), width), 128, np.uint8)
        pixels = np.vstack([grey, chromas])
    else:
        pixels = grey.astype(np.uint16) * 256 if '16' in encoding else grey
        planes = {'rgb': 3, 'bgr': 3}.get(encoding.rstrip('0123456789'), 1)
        planes = 4 if 'bgra' in encoding or 'rgba' in encoding else planes
        pixels = np.dstack([pixels] * planes) if planes > 1 else pixels
    image = Image(height=height, width=width, encoding=encoding, step=pixels.nbytes // (
        pixels.shape[0]), data=array('B', pixels.tobytes()))
    image.header.stamp = from_ns(stamp_ns)
    return image


def frames() -> Iterator[tuple[int, np.ndarray]]:
    """Yield stamps and frames of a light that flashes in every other one."""
    random = np.random.default_rng(4)
    light = 100.0 * gaussian(44.3, 34.7, 1.5)
    looks = [digitised(BACKGROUND + light * (k % 2), random) for k in range(8)]
    return ((FIRST_NS + k * STEP_NS, looks[k % 8]) for k in itertools.count())


def said(diagnostics: list[DiagnosticArray], sentence: str) -> bool:
    """Tell whether a node said this."""
    return any(sentence in each.status[0].message for each in diagnostics)


def shown(diagnostics: list[DiagnosticArray], key: str) -> str:
    """Return what a node showed last."""
    return next((pair.value for each in reversed(diagnostics) for pair in each.status[0].values
                 if pair.key == key), '')


def test_every_encoding_with_a_camera_info_of_another_stamp(domain: int) -> None:
    """A window of each; 120 us between image and camera_info are told and no more."""
    with probe(domain) as node, start('segmenter', domain) as process:
        windows = node.record(Image, 'target/window/image_raw')
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        images = node.create_publisher(Image, 'camera/image_raw', IMAGE_OUT)
        infos = node.create_publisher(CameraInfo, 'camera/camera_info', IMAGE_OUT)
        info = from_camera_model(MODEL, SHAPE[1], SHAPE[0])
        coming = frames()

        def publish(encoding: str) -> None:
            stamp_ns, grey = next(coming)
            images.publish(encoded(grey, encoding, stamp_ns))
            infos.publish(stamped(info, stamp_ns + 120_000, 'optical'))
            node.spin(0.005)

        for encoding in ENCODINGS:
            begin_ns = next(coming)[0]

            def seen() -> bool:
                return any(to_ns(each.header.stamp) > begin_ns for each in windows)

            node.spin_until(lambda: publish(encoding) or seen())
        node.spin_until(lambda: publish('mono8') or shown(diagnostics, 'camera_info offset (ms)'))
        assert shown(diagnostics, 'camera_info offset (ms)') == '0.120'
        assert not said(diagnostics, 'without a')
    assert 'stamps 0.120 ms after those of camera/image_raw' in process.output


def compressed(data: bytes, form: str, stamp_ns: int) -> CompressedImage:
    """Return a message as compressed_image_transport makes it."""
    message = CompressedImage(format=form, data=array('B', data))
    message.header.stamp = from_ns(stamp_ns)
    return message


def test_compressed_frames_without_a_camera_info(domain: int, tmp_path: Path) -> None:
    """The other transport is named; then the JPEG's own steps and the stand-in are used."""
    write_calibration(tmp_path / 'camera.yaml', MODEL)
    with probe(domain) as node, start(
        'segmenter', domain, camera_info_url=f'file://{tmp_path}/camera.yaml'
    ):
        windows = node.record(Image, 'target/window/image_raw')
        infos = node.record(CameraInfo, 'target/window/camera_info')
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        images = node.create_publisher(CompressedImage, 'camera/image_raw/compressed', IMAGE_OUT)
        coming = frames()

        def publish(cut: int | None = None, suffix: str = '.jpg', form: str = 'jpeg') -> None:
            stamp_ns, grey = next(coming)
            data = cv2.imencode(suffix, grey)[1].tobytes()[:cut]
            images.publish(compressed(data, f'mono8; {form} compressed ', stamp_ns))
            node.spin(0.01)

        def play(until: Callable[[], object], *arguments: Any) -> None:
            node.spin_until(lambda: publish(*arguments) or until())

        play(lambda: said(diagnostics, '/image_raw/compressed; set image_transport: compressed'))
        assert node.set_parameter('segmenter', 'image_transport', 'compressed').successful
        play(lambda: windows)
        assert {each.encoding for each in windows} == {'8UC3'}  # the third has the JPEG's noise
        assert infos[-1].k[0] == pytest.approx(MODEL.matrix[0, 0])
        play(lambda: said(diagnostics, 'the JPEG is cut short or damaged'), -200)
        assert int(shown(diagnostics, 'images refused')) > 0
        play(lambda: said(diagnostics, 'the PNG is cut short or damaged'), -200, '.png', 'png')
        windows.clear()
        play(lambda: '8UC2' in {each.encoding for each in windows}, None, '.png', 'png')
        assert shown(diagnostics, 'camera_info') == 'that of camera_info_url'
