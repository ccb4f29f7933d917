"""Isolation of the tests: localhost only, a domain of its own for each, none left running."""

from __future__ import annotations

from collections.abc import Iterator
import itertools
import os
from pathlib import Path

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


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Have whatever starts nodes run one after the other, beside what only computes."""
    folder = Path(__file__).parent
    with_nodes = set()
    for item in items:
        room = item.path.relative_to(folder).parts[0]
        if room in ('examples', 'nodes', 'vm') or 'domain' in getattr(item, 'fixturenames', ()):
            item.add_marker(pytest.mark.xdist_group('nodes'))
            with_nodes.add(item)
    # They take longest: they begin, and the rest runs meanwhile.
    items.sort(key=lambda item: item not in with_nodes)


@pytest.fixture
def domain() -> Iterator[int]:
    """Give a ROS domain that no other test of this run uses."""
    yield next(_DOMAINS)
