"""What a process takes of the machine."""

from __future__ import annotations

import os
from pathlib import Path
import time

PAGE_BYTES = os.sysconf('SC_PAGE_SIZE')  # bytes
PAGES = Path('/proc/self/statm')


class Load:
    """Processor time since it was last asked for, and memory now."""

    def __init__(self) -> None:
        self._wall = time.monotonic()
        self._busy = time.process_time()

    def cpu(self) -> float:
        """Return the part of one core that the process had since the last call, %."""
        wall, busy = time.monotonic(), time.process_time()
        part = (busy - self._busy) / max(wall - self._wall, 1e-9)
        self._wall, self._busy = wall, busy
        return 100.0 * part

    @staticmethod
    def memory() -> float:
        """Return the resident memory of the process (proc(5), statm), MB."""
        return 1e-6 * PAGE_BYTES * int(PAGES.read_text().split()[1])
