"""Isolation of the tests: localhost only, a domain of its own for each, none left running."""

from __future__ import annotations

from collections.abc import Iterator
import itertools
import os
from pathlib import Path
import shutil
import signal
import tempfile
from typing import Any

from blob_tracker.resources import config_path
import pytest
from support.slowness import measure_reference, slowness
from support.tf2_messages import provide_tf2_messages

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
    'benchmarks/test_latency', 'clients', 'commands/calibrate', 'commands/test_demo',
    'commands/test_doctor', 'commands/test_echo', 'commands/test_replay', 'examples', 'nodes',
    'test_security', 'test_views',
)
VIRTUAL_MACHINE = ('vm',)
# Left to `make test` by `make check`, beside those: the same tests again with another library.
AGAIN = ('test_opencv5',)
# What computes longest, the longest first; and what takes up the others' results, last.
LONG = (
    'commands/test_study.py::test_quick_run[causes]',
    'commands/test_study.py::test_quick_run[beyond]',
    'commands/test_study.py::test_quick_run[growing_target]',
    'commands/test_study.py::test_quick_run[locale_table]',
    'commands/test_study.py::test_quick_run[table_5_6]',
    'commands/test_study.py::test_quick_run[table_5_7]',
    'test_opencv5', 'commands/test_study', 'studies/beyond', 'benchmarks', 'kernel',
    'simulation', 'calibration', 'studies',
)
# Its tests are shared out one by one: each is long, and none needs what another has prepared.
SINGLE = 'commands/test_study.py'
LAST = f'{SINGLE}::test_all_quick'
HERE = Path(__file__).parent


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the option of `make check`."""
    parser.addoption(
        '--core', action='store_true',
        help='without the tests that start nodes or a virtual machine, or repeat others',
    )


def pytest_configure(config: pytest.Config) -> None:
    """Prepare what the processes of a run share."""
    if not hasattr(config, 'workerinput'):
        measure_reference()
        os.environ['QUICK_STUDIES'] = tempfile.mkdtemp(prefix='quick_studies_')


def pytest_unconfigure(config: pytest.Config) -> None:
    """Leave nothing of it behind."""
    if not hasattr(config, 'workerinput'):
        shutil.rmtree(os.environ['QUICK_STUDIES'], ignore_errors=True)


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Leave out what `--core` does not want, before it is imported."""
    place = collection_path.relative_to(HERE).as_posix() if HERE in collection_path.parents else ''
    left_out = place.startswith(WITH_PROCESSES + VIRTUAL_MACHINE + AGAIN)
    return True if config.getoption('--core') and left_out else None


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Give a test the longer, the slower the machine is as it begins."""
    marker = item.get_closest_marker('timeout')
    general = item.config.getoption('timeout') or item.config.getini('timeout')
    limit = float(marker.args[0] if marker else general)
    options = marker.kwargs if marker else {}
    item.add_marker(pytest.mark.timeout(limit * slowness(), **options), append=False)
    return (yield)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Have what starts nodes run one after the other, beside what only computes."""
    from xdist.scheduler import LoadScopeScheduling

    class NodesAndTheRest(LoadScopeScheduling):
        """
        The first process begins with what starts nodes, the others with the virtual machine.

        That is what takes longest; then comes what computes. Who is done with his own part takes
        of the other's.
        """

        def _split_scope(self, nodeid: str) -> str:
            place = nodeid.removeprefix('test/')
            if place.startswith(VIRTUAL_MACHINE):
                return place.partition('/')[0]
            return place if place.startswith(SINGLE) else place.partition('::')[0]

        def _assign_work_unit(self, node: Any) -> None:
            first = node is next(iter(self.assigned_work))
            scope = min(self.workqueue, key=lambda scope: _turn(scope, nodes_first=first))
            self.workqueue.move_to_end(scope, last=False)
            super()._assign_work_unit(node)

    return NodesAndTheRest(config, log)


def _turn(scope: str, *, nodes_first: bool) -> tuple[int, int]:
    """Return when a part of the tests is due: the smallest comes next."""
    if scope.startswith(WITH_PROCESSES):
        return (-1 if nodes_first else 3), 0
    if scope.startswith(VIRTUAL_MACHINE):
        return 0, 0
    long = [place for place, name in enumerate(LONG) if scope.startswith(name)]
    return (4 if scope == LAST else 1 if long else 2), min(long, default=0)


@pytest.fixture(scope='session', autouse=True)
def elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """
    Work in an empty folder.

    A Python that is started in the checkout imports what lies there, in place of the package that
    is installed, and compiles it first.
    """
    before = Path.cwd()
    os.chdir(tmp_path_factory.mktemp('elsewhere'))
    yield
    os.chdir(before)


@pytest.fixture
def domain() -> int:
    """Give a ROS domain that no other test of this run uses."""
    return next(_DOMAINS)


@pytest.fixture(scope='module')
def module_domain() -> int:
    """Give one to all tests of a file."""
    return next(_DOMAINS)


@pytest.fixture(scope='session')
def tf2_messages() -> None:
    """Have the messages of TF, here and in the nodes that are started from now on."""
    provide_tf2_messages()
