"""Isolation of the tests: localhost only, a domain of its own for each, none left running."""

from __future__ import annotations

from collections.abc import Iterator
import itertools
import os

import pytest

from blob_tracker.resources import config_path

os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
os.environ['FASTRTPS_DEFAULT_PROFILES_FILE'] = str(config_path('fastdds.xml'))
# Domains above 101 run into the ephemeral ports of Linux. Runs side by side begin elsewhere.
_DOMAINS = itertools.cycle(range(1, 102))
for _ in range(os.getpid() % 101):
    next(_DOMAINS)


@pytest.fixture
def domain() -> Iterator[int]:
    """Give a ROS domain that no other test of this run uses."""
    yield next(_DOMAINS)
