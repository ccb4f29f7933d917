"""What a process takes of the machine."""

from __future__ import annotations

import time

from blob_tracker.ros.diagnostics.load import Load
import numpy as np


def test_a_sleeper_takes_less_than_a_worker():
    """The time of the processor, not that of the wall."""
    load = Load()
    time.sleep(0.1)
    asleep = load.cpu()
    end = time.process_time() + 0.05
    while time.process_time() < end:
        pass
    assert 0.0 <= asleep < load.cpu()


def test_memory_grows_with_what_is_kept():
    """64 MB that are written to are there; pages that are not are not."""
    before = Load.memory()
    kept = np.ones(8 * 1024 * 1024)
    grown = Load.memory() - before
    assert 60.0 < grown < 80.0, kept.size
