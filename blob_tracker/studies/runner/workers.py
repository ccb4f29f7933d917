"""Where the jobs run: processes of this machine, or a Dask cluster."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
import os
import signal

PATIENCE = 10.0  # s that a cluster's scheduler may take to answer
THREADS = ('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS', 'MKL_NUM_THREADS')


class ClusterError(RuntimeError):
    """A cluster that cannot be used; the message says why and what would help."""


@contextmanager
def workers(count: int, dask: str | None) -> Iterator[tuple[Executor, int]]:
    """
    Yield an executor, and how many jobs it can do at once.

    Parameters
    ----------
    count : int
        Processes on this machine.
    dask : str or None
        Address of a Dask scheduler that is used instead, as tcp://192.168.1.5:8786.

    Raises
    ------
    ClusterError
        If Dask is not installed or no scheduler answers.

    """
    if dask is not None:
        with _cluster(dask) as cluster:
            yield cluster
        return
    for name in THREADS:  # the processes are the parallelism
        os.environ.setdefault(name, '1')
    # Spawned, not forked: Numba and OpenCV have threads that a fork would leave behind.
    executor = ProcessPoolExecutor(count, get_context('spawn'), _leave_interrupts)
    try:
        yield executor, count
    finally:
        # A second Ctrl-C would leave processes that wait for each other.
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
        executor.shutdown(cancel_futures=True)
        signal.signal(signal.SIGINT, before)


def _leave_interrupts() -> None:
    """Let Ctrl-C be for the process that gives out the jobs."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _cluster(address: str) -> Iterator[tuple[Executor, int]]:
    try:
        from distributed import Client
    except ImportError:
        raise ClusterError(
            '--dask needs Dask on this machine and on the workers: '
            "pip install 'blob_tracker[cluster]', or distributed"
        ) from None
    try:
        client = Client(address, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise ClusterError(f'no Dask scheduler answers at {address}: {error}') from None
    with client:
        executor = client.get_executor()
        try:
            yield executor, max(sum(client.ncores().values()), 1)
        finally:
            executor.shutdown(wait=False)
