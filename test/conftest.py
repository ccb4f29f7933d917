"""Isolation of the tests: localhost only, a domain of its own for each, none left running."""

from __future__ import annotations

import itertools
import os
import signal
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

# A run in the background of a script inherits that Ctrl-C is ignored, and so would its nodes.
signal.signal(signal.SIGINT, signal.default_int_handler)

# What starts nodes in processes, by the beginning of its path in here.
WITH_PROCESSES = (
    'benchmarks/test_latency', 'commands/calibrate', 'commands/test_demo', 'commands/test_doctor',
    'commands/test_replay', 'examples', 'nodes', 'test_launch', 'test_security', 'test_views',
)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Have what starts nodes run one after the other, beside what only computes."""
    from xdist.scheduler import LoadScopeScheduling

    class NodesTogether(LoadScopeScheduling):
        """One process gets all that starts nodes, the other the virtual machine and the rest."""

        def _split_scope(self, nodeid: str) -> str:
            place = nodeid.removeprefix('test/')
            if place.startswith('vm'):
                return 'vm'
            return 'nodes' if place.startswith(WITH_PROCESSES) else nodeid

    return NodesTogether(config, log)


@pytest.fixture
def domain() -> int:
    """Give a ROS domain that no other test of this run uses."""
    return next(_DOMAINS)


@pytest.fixture(scope='module')
def module_domain() -> int:
    """Give one to all tests of a file."""
    return next(_DOMAINS)
