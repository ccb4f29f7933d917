"""Runs in the guest: processes that are forked, as an emulated Python loads for half a minute."""

from __future__ import annotations

from collections.abc import Callable
import faulthandler
import os
from pathlib import Path
import sys
import time
import traceback

from blob_tracker.nodes import start


class Fork:
    """
    A copy of this process that does something and ends.

    It is made at once, so that it has nothing of what comes later, as ROS, and waits for `begin`.

    Parameters
    ----------
    action : callable
        What it does; it ends with its exit code.
    log : Path, optional
        Gets what it prints.

    """

    def __init__(self, action: Callable[[], object], log: Path | None = None) -> None:
        begun, self._begin = os.pipe()
        sys.stdout.flush()
        sys.stderr.flush()
        self._pid = os.fork()
        self._code: int | None = None
        if self._pid == 0:
            os.close(self._begin)
            os._exit(_exit_code(action, log) if os.read(begun, 1) else 1)
        os.close(begun)

    def begin(self) -> Fork:
        """Let it begin."""
        os.write(self._begin, b'.')
        os.close(self._begin)
        return self

    def send_signal(self, number: int) -> None:
        """Send it a signal."""
        os.kill(self._pid, number)

    def wait(self, longest: float = float('inf')) -> int:
        """Return its exit code, or raise TimeoutError after so many seconds."""
        end = time.monotonic() + longest
        while self._code is None:
            pid, status = os.waitpid(self._pid, os.WNOHANG)
            if pid:
                self._code = os.waitstatus_to_exitcode(status)
            elif time.monotonic() > end:
                raise TimeoutError(f'no end within {longest:.0f} s')
            else:
                time.sleep(0.05)
        return self._code


def node(name: str, *arguments: str, **environment: str) -> Callable[[], None]:
    """Return what the executable of a node does."""
    def run() -> None:
        os.environ.update(environment)
        sys.argv = [name, *arguments]
        faulthandler.enable()
        getattr(start, name)()
    return run


def _exit_code(action: Callable[[], object], log: Path | None) -> int:
    if log is not None:
        with log.open('wb') as file:
            os.dup2(file.fileno(), 1)
            os.dup2(file.fileno(), 2)
    try:
        action()
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else ended.code is not None
    except BaseException:
        traceback.print_exc()
        return 1
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
    return 0
