"""A camera that the test plays: a flashing light, frame by frame, and what is right of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count, product
from math import cos, sin
from typing import Any

from blob_tracker.camera import CameraModel
from blob_tracker.ros.endpoints.qos import IMAGE_OUT
from blob_tracker.ros.messages.camera_info import from_camera_model, stamped
from blob_tracker.ros.messages.image import from_pixels
from blob_tracker.ros.messages.stamp import to_ns
from blob_tracker.simulation import Scene
import cv2
from geometry_msgs.msg import PoseWithCovarianceStamped, Vector3Stamped
import numpy as np
from numpy.typing import NDArray
from rclpy.qos import QoSProfile
from sensor_msgs.msg import CameraInfo, Image
from support.processes import Probe

DEEP = 5000  # bearings that may wait to be taken
ON_THE_WAY = 0.2  # s from a bearing to its ray, of the same node
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
    scene : Scene
        What the camera sees; its light moves far enough from frame to frame to tell them apart.
    namespace : str
        Of the nodes that it plays to.
    qos : QoSProfile
        Of both topics.

    """

    def __init__(
        self,
        node: Probe,
        scene: Scene,
        namespace: str = '',
        qos: QoSProfile = IMAGE_OUT,
    ) -> None:
        self.node = node
        self.scene = scene
        self.model = CameraModel.from_field_of_view(scene.width, scene.height, FIELD_OF_VIEW)
        self.stamp_ns = 10**18
        self.sent: dict[int, list[Sent]] = {}
        self.unknown: set[int] = set()  # stamps under which nobody can tell what is right
        self.bearings = node.record(Vector3Stamped, f'{namespace}target/bearing', DEEP)
        self.rays = node.record(PoseWithCovarianceStamped, f'{namespace}target/ray', DEEP)
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
        indices = count(1)

        def seen() -> bool:
            before()
            self.send(next(indices))
            self.node.spin(0.01)
            return bool(self.bearings)

        self.node.spin_until(seen)

    def flash(self, before: Callable[[], None] = lambda: None) -> int:
        """
        Send frames from the first on until one of them has its bearing; return how many.

        An image may be lost, and how many flashes it takes depends on what was sent before.
        """
        begin_ns = self.stamp_ns = self.stamp_ns + 10**9  # nothing pairs with what came before
        indices = count(1)
        index = 0

        def seen() -> bool:
            nonlocal index
            index = next(indices)
            before()
            self.send(index)
            self.node.spin(0.005)
            return self.located(begin_ns)

        self.node.spin_until(seen)
        return index

    def located(self, after_ns: int) -> bool:
        """Tell whether the bearing of a frame after a stamp has come."""
        return any(
            after_ns < to_ns(each.header.stamp) <= self.stamp_ns for each in self.bearings[-50:]
        )

    def expect_right(self) -> None:
        """Expect each bearing so far to be right of what was sent under its stamp; forget it."""
        self.node.settle(ON_THE_WAY)
        sigmas = {
            to_ns(ray.header.stamp): np.sqrt(np.array(ray.pose.covariance)[[28, 21]]) * 1e3
            for ray in self.rays
        }
        for bearing in self.bearings:
            stamp_ns = to_ns(bearing.header.stamp)
            sent = self.sent.get(stamp_ns, [])
            sigma = sigmas.get(stamp_ns)
            if sigma is None and sent:
                continue  # of more than ten at once the queue of the rays keeps ten
            assert sigma is not None, (bearing, 'of a stamp that was never sent')
            assert np.isfinite(sigma).all(), (bearing, sigma)
            # Of two calibrations under one stamp nobody can tell which goes with which frame.
            right = any(
                is_right(bearing, sigma, Sent(frame.place, other.info))
                for frame, other in product(sent, repeat=2)
            )
            assert right or stamp_ns in self.unknown, (bearing, sigma, sent)
        self.bearings.clear()
        self.rays.clear()


def is_right(bearing: Vector3Stamped, sigma: NDArray[np.float64], sent: Sent) -> bool:
    """Tell whether a bearing, with its sigmas in mrad, is imaged where the light was sent."""
    if sent.place is None:
        return False
    angles = np.array([bearing.vector.x, bearing.vector.y])
    steps = np.array([[0.0, 0.0], [sigma[0], 0.0], [0.0, sigma[1]]])
    there, *aside = (imaged(angles + step, sent.info) for step in steps)
    within = TOLERANCE + SIGMAS * sum(np.hypot(*(each - there)) for each in aside)
    return bool(np.hypot(*(there - sent.place)) < within)


def imaged(angles: NDArray[np.float64], info: CameraInfo) -> NDArray[np.float64]:
    """Return the (x, y) px of an image on which a direction, mrad, is imaged, by OpenCV."""
    a, e = 1e-3 * angles  # azimuth and elevation, rad
    ray = np.array([[[sin(a) * cos(e), -sin(e), cos(a) * cos(e)]]])
    project: Callable[..., Any] = cv2.projectPoints
    coefficients, none = np.array(info.d, dtype=float), np.zeros(3)
    if info.distortion_model in ('equidistant', 'fisheye'):
        project = cv2.fisheye.projectPoints
        coefficients = coefficients if coefficients.size else np.zeros(4)
    # As pixels of the matrix that is given here: of K, OpenCV leaves the skew out.
    places = project(ray, none, none, np.eye(3), coefficients)[0].ravel()
    x, y, _ = np.reshape(info.k, (3, 3)) @ [*places, 1.0]
    return np.array([
        (x - info.roi.x_offset + 0.5) / max(info.binning_x, 1) - 0.5,
        (y - info.roi.y_offset + 0.5) / max(info.binning_y, 1) - 0.5,
    ])
