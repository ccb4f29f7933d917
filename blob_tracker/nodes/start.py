"""The executables: help without ROS, and a Ctrl-C that ends a node while it is loading."""

import gc
from importlib import import_module
import shutil
import signal
import sys

from blob_tracker.nodes.help import help_text
from blob_tracker.nodes.interface import interface_of

WIDEST = 99  # columns: longer lines are hard to read


def camera() -> None:
    """Run the camera node."""
    _start('camera')


def segmenter() -> None:
    """Run the segmenter node."""
    _start('segmenter')


def locator() -> None:
    """Run the locator node."""
    _start('locator')


def tracker() -> None:
    """Run the tracker node."""
    _start('tracker')


def triangulator() -> None:
    """Run the triangulator node."""
    _start('triangulator')


def pipeline() -> None:
    """Run camera, segmenter, locator and tracker in one process."""
    _start('pipeline')


def simulator() -> None:
    """Run the simulator node."""
    _start('simulator')


def _start(name: str) -> None:
    """Load a node and run it, or say what it is."""
    # Python's own handler would print where in the imports it was; rclpy puts in another later.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    words = sys.argv[1:]
    if '--ros-args' in words:  # what follows is rclpy's
        words = words[: words.index('--ros-args')]
    if '--help' in words or '-h' in words:
        columns = shutil.get_terminal_size((WIDEST, 0)).columns
        print(help_text(interface_of(name), min(columns, WIDEST)))
        return
    gc.disable()  # until all is loaded, see ros/process.py
    import_module(f'blob_tracker.nodes.{name}').main()
