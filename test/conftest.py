"""Isolation of the tests: localhost only, a domain of its own for each, none left running."""

from __future__ import annotations

from collections.abc import Iterator
import itertools
import os
from typing import Any

from blob_tracker.resources import config_path
import pytest

os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
os.environ['FASTRTPS_DEFAULT_PROFILES_FILE'] = str(config_path('fastdds.xml'))
# Domains above 101 run into the ephemeral ports of Linux, and 0 is everybody's. The processes of
# one run share them out; runs side by side begin elsewhere, and may meet all the same: give each a
# network of its own (unshare --net).
_WORKERS = int(os.environ.get('PYTEST_XDIST_WORKER_COUNT', 1))
_WORKER = int(os.environ.get('PYTEST_XDIST_WORKER', 'gw0').removeprefix('gw'))
_DOMAINS = itertools.cycle(range(1 + _WORKER, 101, _WORKERS))
for _ in range(os.getppid() % 100):
    next(_DOMAINS)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Have whatever starts nodes run one after the other, beside what only computes."""
    from xdist.scheduler import LoadScopeScheduling

    class NodesTogether(LoadScopeScheduling):
        """One process gets the tests of these folders, which take longest and so begin."""

        def _split_scope(self, nodeid: str) -> str:
            room = nodeid.removeprefix('test/').partition('/')[0]
            return 'nodes' if room in ('examples', 'nodes', 'vm') else nodeid

    return NodesTogether(config, log)


@pytest.fixture
def domain() -> Iterator[int]:
    """Give a ROS domain that no other test of this run uses."""
    yield next(_DOMAINS)
