"""One light: its tracker, what is published of it, and how well its bearings fit."""

from __future__ import annotations

from collections import deque

from blob_tracker.ros.health import Health, WARN
from blob_tracker.ros.names import target_topic
from blob_tracker.ros.track_topics import TrackTopics
from blob_tracker.tracking import MODELS, StampJump, Track, Tracker, TrackingError
from blob_tracker.types import Bearing
import numpy as np
from rclpy.node import Node

JUDGED = 100  # bearings: their mean normalised innovation squared is known to 0.2
FEWEST = 30  # of them that are worth a word
# Where that should be 2, the degrees of freedom: five standard errors above it, with the fewest.
SUSPICIOUS = 4.0
MOST = 50.0  # that one bearing counts in it: a target that leaps says nothing of the filter
MISSED = 2.5  # usual times between two bearings, after which one is missing
MRAD = 1e-3  # rad


class LightTrack:
    """
    Follow one light and publish where it will be.

    Parameters
    ----------
    node : Node
        Publishes it.
    health : Health
        Hears of bearings that are refused.
    light : str
        Name of the light; empty for the only one.

    """

    def __init__(self, node: Node, health: Health, light: str) -> None:
        self._node, self._health = node, health
        self._topic = target_topic(light)
        self._topics = TrackTopics(node, self._topic)
        self._name = f'{light}: ' if light else ''
        self._frame_id = ''
        self._tracker: Tracker
        self._base_frame_id = ''
        self._innovations: deque[float] = deque(maxlen=JUDGED)
        self._interval_ns = 0
        self._resets = 0
        self._prediction: Track | None = None

    def use(self, tracker: Tracker, base_frame_id: str) -> None:
        """
        Begin afresh with another tracker.

        Parameters
        ----------
        tracker : Tracker
            Follows the light from now on.
        base_frame_id : str
            Name of the frame of its predictions; empty for that of the bearings.

        """
        self._tracker, self._base_frame_id = tracker, base_frame_id
        self._innovations.clear()

    def reset(self) -> None:
        """Forget where the light was: what follows is of another time."""
        self._tracker.reset()
        self._resets += 1

    def forget(self, after_ns: int) -> None:
        """Forget where the light was if that has a later stamp, ns."""
        newest_ns = self._tracker.stamp_ns
        if newest_ns is not None and newest_ns > after_ns:
            self.reset()

    def take(self, bearing: Bearing, frame_id: str) -> bool:
        """Filter a bearing and publish the track; False, and why in `health`, where refused."""
        before_ns = self._tracker.stamp_ns
        try:
            self._filter(bearing)
        except TrackingError as error:
            self._health.fault(WARN, f'{self._topic}/ray: {error}')
            self._health.count(f'{self._name}bearings refused')
            return False
        finally:
            self._remember_innovation()
        newest_ns = self._tracker.stamp_ns
        assert newest_ns is not None
        if before_ns is not None and newest_ns > before_ns:
            self._interval_ns = newest_ns - before_ns
        self._frame_id = frame_id
        track = self._tracker.seen_at(newest_ns)
        if track is not None:
            self._topics.publish(track, frame_id)
        return True
