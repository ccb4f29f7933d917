"""Processes that are measured: started, asked, ended, and looked at from outside."""

from __future__ import annotations

import json
import os
from pathlib import Path
import select
import subprocess
import sys
from tempfile import TemporaryFile
from typing import Any

ROOT = Path(__file__).parents[2]
EXIT = 10.0  # s
PATIENCE = 60.0  # s
TICK = os.sysconf('SC_CLK_TCK')
MB = 1e6
LAST_WORDS = 2000  # bytes


def environment(root: Path = ROOT) -> dict[str, str]:
    """
    Return that of all processes of a run: a domain of its own, on this machine alone.

    `root` is the source tree that they are of; another one than this has another domain.
    """
    own = dict(os.environ)
    own.pop('PYTHONDONTWRITEBYTECODE', None)  # or each process would compile the sources
    return dict(
        own,
        # Domains above 101 run into the ephemeral ports of Linux.
        ROS_DOMAIN_ID=str(1 + (os.getpid() + (root != ROOT)) % 101),
        ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST',
        FASTRTPS_DEFAULT_PROFILES_FILE=str(root / 'config' / 'fastdds.xml'),
        PYTHONPATH=os.pathsep.join([str(root), os.environ.get('PYTHONPATH', '')]),
    )


class Process:
    """
    A module of this package in a process of its own; ends with the block that it is used in.

    Parameters
    ----------
    module : str
        Its name; or the path of a file of this tree's.
    arguments : str
        Its command line.
    root : Path
        The source tree that it is of.

    """

    def __init__(self, module: str, *arguments: str, root: Path = ROOT) -> None:
        self._name = ' '.join((module, *arguments))
        self._words = TemporaryFile()
        run = [module] if module.endswith('.py') else ['-m', f'benchmarks.latency.{module}']
        self._popen = subprocess.Popen(
            [sys.executable, *run, *arguments],
            # The folder it runs in comes before PYTHONPATH.
            env=environment(root), cwd=root, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=self._words, text=True,
        )

    def ask(self, request: object) -> None:
        """Send a line."""
        assert self._popen.stdin is not None
        self._popen.stdin.write(json.dumps(request) + '\n')
        self._popen.stdin.flush()

    def answer(self, timeout: float = PATIENCE) -> Any:
        """
        Return the next line that it reports.

        Raises
        ------
        TimeoutError
            If none comes within the time, s.
        RuntimeError
            If it ended instead, with what it said.

        """
        assert self._popen.stdout is not None
        # It writes whole lines and is asked for one at a time: nothing waits in Python's buffer.
        if not select.select([self._popen.stdout], [], [], timeout)[0]:
            raise TimeoutError(f'{self._name} says nothing for {timeout:.0f} s: {self._said()}')
        line = self._popen.stdout.readline()
        if not line:
            raise RuntimeError(f'{self._name} ended: {self._said()}')
        return json.loads(line)

    def _said(self) -> str:
        """Return the end of what it wrote for people."""
        # Not seek and read: the process writes at the same offset of the file as we would read at.
        descriptor = self._words.fileno()
        begin = max(os.fstat(descriptor).st_size - LAST_WORDS, 0)
        return os.pread(descriptor, LAST_WORDS, begin).decode(errors='replace')

    def wait(self, timeout: float = PATIENCE) -> None:
        """Wait until it ends by itself."""
        self._popen.wait(timeout)

    def interrupt(self) -> None:
        """Press Ctrl-C."""
        self._popen.send_signal(2)

    def close_input(self) -> None:
        """Say that nothing more will be asked."""
        assert self._popen.stdin is not None
        self._popen.stdin.close()

    def busy(self) -> float:
        """Return the seconds of processor time that it has used."""
        fields = Path(f'/proc/{self._popen.pid}/stat').read_text().rpartition(')')[2].split()
        return (int(fields[11]) + int(fields[12])) / TICK  # utime, stime: proc(5)

    def memory(self) -> float:
        """Return its resident memory, MB."""
        return self._status('VmRSS')

    def own_memory(self) -> float:
        """Return that without the pages of files, which processes share, MB."""
        return self._status('VmRSS') - self._status('RssFile')

    def proportional_memory(self) -> float:
        """Return its own memory and its part of what it shares with other processes, MB."""
        return self._status('Pss', 'smaps_rollup')

    def _status(self, name: str, file: str = 'status') -> float:
        status = Path(f'/proc/{self._popen.pid}/{file}').read_text()
        (line,) = (line for line in status.splitlines() if line.startswith(f'{name}:'))
        return int(line.split()[1]) * 1024 / MB

    def __enter__(self) -> Process:
        return self

    def __exit__(self, *error: object) -> None:
        assert self._popen.stdout is not None
        if self._popen.poll() is None:
            self._popen.send_signal(2)
        try:
            self._popen.wait(EXIT)
        except subprocess.TimeoutExpired:
            self._popen.kill()
            self._popen.wait()
        self.close_input()
        self._popen.stdout.close()
        self._words.close()
