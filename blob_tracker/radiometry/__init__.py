"""Watts to electrons: what a light sends into a camera at a range, and what the daylight adds."""

from blob_tracker.radiometry.budget import Budget, link_budget
from blob_tracker.radiometry.error import OpticsError
from blob_tracker.radiometry.led import Led
from blob_tracker.radiometry.receiver import Receiver
from blob_tracker.radiometry.sunlight import LEVELS
from blob_tracker.radiometry.surroundings import Surroundings

__all__ = ['Budget', 'LEVELS', 'Led', 'OpticsError', 'Receiver', 'Surroundings', 'link_budget']
