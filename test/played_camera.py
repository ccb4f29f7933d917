"""A camera that the test plays: a flashing light, frame by frame, and what is right of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import atan2, hypot

from blob_tracker.camera import CameraModel
from blob_tracker.ros.camera_info import from_camera_model, stamped
from blob_tracker.ros.image import from_pixels
from blob_tracker.ros.qos import IMAGE_OUT
from blob_tracker.ros.stamp import to_ns
from blob_tracker.simulation import FlashingLight
import cv2
from geometry_msgs.msg import PoseWithCovarianceStamped, Vector3Stamped
import numpy as np
from numpy.typing import NDArray
from processes import PATIENCE, Probe
from rclpy.qos import QoSProfile
from sensor_msgs.msg import CameraInfo, Image

FRAMES = 12  # flashes enough to be sure of the target
STEP_NS = 16_666_667
FIELD_OF_VIEW = 40.0  # degrees
# px that a right bearing may be off, and sigmas of its own covariance: random pixels in one of
# the two frames are noise that the locator sees and says.
TOLERANCE, SIGMAS = 0.1, 6.0


@dataclass(frozen=True)
class Sent:
    """What was sent under a stamp: where the light is in the picture, and the calibration."""

    place: tuple[float, float] | None  # px; None where it shows none
    info: CameraInfo


class PlayedCamera:
    """
    Publish the frames of a scene, and judge the bearings that come of them.

    Parameters
    ----------
    node : Probe
        Publishes, and takes what comes back.
    scene : FlashingLight
        What the camera sees; its light moves far enough from frame to frame to tell them apart.
    namespace : str
        Of the nodes that it plays to.
    qos : QoSProfile
        Of both topics.

    """

    def __init__(
        self,
        node: Probe,
        scene: FlashingLight,
        namespace: str = '',
        qos: QoSProfile = IMAGE_OUT,
    ) -> None:
        self.node = node
        self.scene = scene
        self.model = CameraModel.from_field_of_view(scene.width, scene.height, FIELD_OF_VIEW)
        self.stamp_ns = 10**18
        self.sent: dict[int, list[Sent]] = {}
        self.unknown: set[int] = set()  # stamps under which nobody can tell what is right
        self.bearings = node.record(Vector3Stamped, f'{namespace}target/bearing', 1000)
        self.rays = node.record(PoseWithCovarianceStamped, f'{namespace}target/ray', 1000)
        self.images, self.infos = (
            node.create_publisher(kind, f'{namespace}camera/{name}', qos)
            for kind, name in ((Image, 'image_raw'), (CameraInfo, 'camera_info'))
        )

    def messages(self, index: int) -> tuple[Image, CameraInfo]:
        """Return the messages of the next frame, a step later."""
        self.stamp_ns += STEP_NS
        scene = self.scene
        image = from_pixels(scene.frame(index), self.stamp_ns, 'optical')
        info = from_camera_model(self.model, scene.width, scene.height)
        return image, stamped(info, self.stamp_ns, 'optical')

    def send(self, index: int) -> None:
        """Publish a frame."""
        image, info = self.messages(index)
        self.note(self.stamp_ns, Sent(self.place(index), info))
        self.images.publish(image)
        self.infos.publish(info)

    def send_again(self, index: int, image: Image, info: CameraInfo) -> None:
        """Publish messages of a frame that was drawn before, under the stamp of now."""
        for message in (image, info):
            stamped(message, self.stamp_ns, 'optical')
        self.note(self.stamp_ns, Sent(self.place(index), info))
        self.images.publish(image)
        self.infos.publish(info)

    def place(self, index: int) -> tuple[float, float] | None:
        """Return where the light is in a frame, px; None where it is off."""
        truth = self.scene.truth(index)
        return (truth.x, truth.y) if truth.lit else None

    def note(self, stamp_ns: int, sent: Sent) -> None:
        """Remember what was sent under a stamp."""
        self.sent.setdefault(stamp_ns, []).append(sent)

    def discover(self, before: Callable[[], None] = lambda: None) -> None:
        """Send flashes until the first bearing comes back: discovery has many ends."""
        count = iter(range(1, 10**9))

        def seen() -> bool:
            before()
            self.send(next(count))
            self.node.spin(0.01)
            return bool(self.bearings)

        self.node.spin_until(seen, 3.0 * PATIENCE)  # several processes start at once

    def flash(self, before: Callable[[], None] = lambda: None) -> None:
        """Send frames, and again where an image was lost, until the last one has its bearing."""
        for _ in range(10):
            self.stamp_ns += 10**9  # nothing pairs with what came before
            for index in range(1, FRAMES + 1):
                before()
                self.send(index)
                self.node.spin(0.005)
            try:
                self.node.spin_until(lambda: self.located(self.stamp_ns), 2.0)
                return
            except AssertionError:
                continue
        raise AssertionError('no bearing of good frames')

    def located(self, stamp_ns: int) -> bool:
        """Tell whether the bearing of a frame has come."""
        return any(to_ns(each.header.stamp) == stamp_ns for each in self.bearings[-50:])

    def expect_right(self) -> None:
        """Expect each bearing so far to be right of what was sent under its stamp; forget it."""
        sigmas = {
            to_ns(ray.header.stamp): np.sqrt(np.array(ray.pose.covariance)[[28, 21]]) * 1e3
            for ray in self.rays
        }
        for bearing in self.bearings:
            stamp_ns = to_ns(bearing.header.stamp)
            sent = self.sent.get(stamp_ns, [])
            sigma = sigmas.get(stamp_ns, np.zeros(2))
            assert np.isfinite(sigma).all(), (bearing, sigma)
            right = any(self._right(bearing, sigma, each) for each in sent)
            assert right or stamp_ns in self.unknown, (bearing, sigma, sent)
        self.bearings.clear()
        self.rays.clear()

    def _right(self, bearing: Vector3Stamped, sigma: NDArray[np.float64], sent: Sent) -> bool:
        if sent.place is None:
            return False
        azimuth, elevation, focal_length = expected(*sent.place, sent.info)
        within = TOLERANCE / focal_length * 1e3 + SIGMAS * sigma
        error = bearing.vector.x - azimuth, bearing.vector.y - elevation
        return bool((np.abs(error) < within).all())


def expected(x: float, y: float, info: CameraInfo) -> tuple[float, float, float]:
    """Return azimuth and elevation, mrad, of an image's pixel by OpenCV, and focal length, px."""
    binning = max(info.binning_x, 1), max(info.binning_y, 1)
    place = (
        (x + 0.5) * binning[0] - 0.5 + info.roi.x_offset,
        (y + 0.5) * binning[1] - 0.5 + info.roi.y_offset,
    )
    undistort = cv2.undistortPoints
    coefficients = np.array(info.d, dtype=float)
    if info.distortion_model in ('equidistant', 'fisheye'):
        undistort = cv2.fisheye.undistortPoints
        coefficients = coefficients if coefficients.size else np.zeros(4)
    u, v = undistort(
        np.array(place).reshape(1, 1, 2), np.array(info.k).reshape(3, 3), coefficients
    ).ravel()
    return 1e3 * atan2(u, 1.0), 1e3 * atan2(-v, hypot(u, 1.0)), min(info.k[0], info.k[4])
