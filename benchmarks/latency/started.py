"""
A process with an executable of a source tree, as `ros2 run` starts it, and with nothing else.

`python .../started.py locator --ros-args ...` in the folder of any tree: its own package runs.
What a benchmark loads is no part of a start.
"""

from __future__ import annotations

from importlib import import_module
import os
import sys

if __name__ == '__main__':
    sys.path[0] = os.getcwd()  # in place of the folder of this file
    getattr(import_module('blob_tracker.nodes.start'), sys.argv.pop(1))()
