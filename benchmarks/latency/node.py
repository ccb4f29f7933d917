"""
A process with an executable of the package, as `ros2 run` starts it, without an installation.

`python -m benchmarks.latency.node locator --ros-args ...`; at its end it prints when each garbage
collection began, monotonic, and how long it took, ns.
"""

from __future__ import annotations

import atexit
import sys

from benchmarks.latency import pauses
from benchmarks.latency.source import report
from blob_tracker.nodes import start

if __name__ == '__main__':
    atexit.register(report, pauses.watch())
    getattr(start, sys.argv.pop(1))()
