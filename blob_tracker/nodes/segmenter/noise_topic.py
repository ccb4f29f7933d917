"""What a segmenter says of the camera's noise, which it measures on pairs of unlit frames."""

from __future__ import annotations

from blob_tracker.calibration.noise_level_function import NoiseLevelFunction
from blob_tracker.ros.diagnostics.health import Health, WARN
from blob_tracker.ros.endpoints.qos import publisher, STATE
from blob_tracker.ros.messages.target import noise_message
from blob_tracker.types import Frame, Pixels
from geometry_msgs.msg import Vector3Stamped
from rclpy.node import Node

PERIOD_NS = 10**9  # by the stamps, between two pairs that are measured


class NoiseTopic:
    """
    Measure the noise while it is asked for, and publish it once it is known.

    Parameters
    ----------
    node : Node
        Publishes it.
    health : Health
        Shows it, and hears of pairs that cannot be measured.

    """

    def __init__(self, node: Node, health: Health) -> None:
        self._health = health
        self._noises = publisher(node, Vector3Stamped, 'target/noise', STATE)
        self._measured: NoiseLevelFunction | None = None
        self._stamp_ns = 0

    @property
    def measures(self) -> bool:
        """Whether it is asked for."""
        return self._measured is not None

    def enable(self, enabled: bool) -> None:
        """Begin to measure, or go on; or forget what was measured."""
        if not enabled:
            self._measured = None
        elif self._measured is None:
            self._measured = NoiseLevelFunction()

    def measure(self, pair: tuple[Pixels, Pixels] | None, frame: Frame, frame_id: str) -> None:
        """Take the last pair of unlit frames, once a second; publish the noise if it is known."""
        if self._measured is None:
            return
        if pair is None or 0 <= frame.stamp_ns - self._stamp_ns < PERIOD_NS:
            return
        self._stamp_ns = frame.stamp_ns
        try:
            tiles = self._measured.add(*pair, frame.saturation, frame.stamp_ns)
        except ValueError as error:
            self._health.fault(WARN, f'noise.measure: {error}')
            return
        line = self._measured.line()
        if self._measured.curved:
            self._health.fault(WARN, f'noise.measure: {self._measured.curved}')
        gain = read_noise = black_level = f'unknown: {self._measured.reason}'
        if line is not None:
            noise = line.noise
            self._noises.publish(noise_message(noise, frame.stamp_ns, frame_id))
            sigma = line.noise_covariance.diagonal() ** 0.5
            gain = f'{noise.gain:.4g} +- {sigma[0]:.2g} e-/DN'
            read_noise = f'{noise.read_noise:.3g} +- {sigma[1]:.2g} DN'
            # A higher one with more read noise has the same variance.
            black_level = f'at least {noise.black_level:.4g} DN'
        self._health.show('measured gain', gain)
        self._health.show('measured read noise', read_noise)
        self._health.show('measured black level', black_level)
        self._health.show('tiles of the last unlit pair', tiles)
