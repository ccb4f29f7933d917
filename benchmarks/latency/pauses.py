"""The pauses that garbage collection makes in a process."""

from __future__ import annotations

import gc
import time

_pauses: list[tuple[int, int]] = []
_began_ns = 0


def watch() -> list[tuple[int, int]]:
    """Return a list that grows: when each collection began, monotonic, and its length, ns."""
    if _watch not in gc.callbacks:
        gc.callbacks.append(_watch)
    return _pauses


def _watch(phase: str, _: dict[str, int]) -> None:
    global _began_ns
    now_ns = time.monotonic_ns()
    if phase == 'start':
        _began_ns = now_ns
    else:
        _pauses.append((_began_ns, now_ns - _began_ns))
