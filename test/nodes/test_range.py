"""The locator tells how far away a light is where its size or flux is known, and else why not."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.camera import CameraModel
from blob_tracker.ros.endpoints.qos import IMAGE_OUT
from blob_tracker.ros.messages.camera_info import from_camera_model
from blob_tracker.types import Window
from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from sensor_msgs.msg import CameraInfo, Image, Range
from support.discs import disc_window
from support.processes import probe, start
from support.window_messages import from_window, of_window

MODEL = CameraModel.from_field_of_view(320, 240, 40.0)
PSF, FLUX = 1.2, 5000.0  # px, DN
DIAMETER = 0.05  # m


def test_range_by_size_and_flux(domain: int) -> None:
    """Both agree on a disc of 3 px; of a point the flux alone is left; then neither."""
    random = np.random.default_rng(4)
    near, far = (
        replace(disc_window(radius, PSF, FLUX, 21, random), x0=149, y0=109)
        for radius in (3.0, 0.0)
    )
    distance = DIAMETER / 2.0 / np.tan(3.0 / MODEL.matrix[0, 0])
    info = from_camera_model(MODEL, 320, 240)
    with probe(domain) as node, start(
        'locator', domain, range__psf_sigma=PSF, range__diameter=DIAMETER,
        range__reference_distance=2.0, range__reference_flux=FLUX * (distance / 2.0) ** 2,
    ):
        ranges = node.record(Range, 'target/range')
        diagnostics = node.record(DiagnosticArray, '/diagnostics')
        images = node.create_publisher(Image, 'target/window/image_raw', IMAGE_OUT)
        infos = node.create_publisher(CameraInfo, 'target/window/camera_info', IMAGE_OUT)
        stamp_ns = 10**18

        def send(window: Window) -> None:
            nonlocal stamp_ns
            stamp_ns += 10**7
            sent = replace(window, stamp_ns=stamp_ns)
            images.publish(from_window(sent, 'optical'))
            infos.publish(of_window(info, sent, 'optical'))
            node.spin(0.02)

        def wait_for(window: Window, *, sized: bool) -> Range:
            ranges.clear()
            node.spin_until(lambda: send(window) or any(
                (each.field_of_view > 0.0) is sized for each in ranges))
            return next(each for each in ranges if (each.field_of_view > 0.0) is sized)

        for window, sized in ((near, True), (far, False)):
            found = wait_for(window, sized=sized)
            assert abs(found.range - distance) < 5.0 * found.variance**0.5
            assert 0.0 < found.variance**0.5 < 0.03 * distance
        assert node.set_parameter('locator', 'range.reference_distance', 0.0).successful is False
        sentence = 'target: no range: size and flux give '
        assert node.set_parameter('locator', 'range.diameter', 1.0).successful
        node.spin_until(lambda: send(near) or any(
            sentence in each.status[0].message for each in diagnostics))
