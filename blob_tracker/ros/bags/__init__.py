"""Bags of ROS 2 and ROS 1, whole or as a killed recorder left them; no ROS is needed."""

from blob_tracker.ros.bags.bag import Bag, is_bag, NO_ROSBAGS, opened
from blob_tracker.ros.bags.topic import READABLE, RecordingError, Topic

__all__ = ['Bag', 'is_bag', 'NO_ROSBAGS', 'opened', 'READABLE', 'RecordingError', 'Topic']
