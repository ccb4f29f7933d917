"""The executables: Ctrl-C ends a node that is still loading without a word, then it is loaded."""

from importlib import import_module
import signal


def camera() -> None:
    """Run the camera node."""
    _start('camera')


def segmenter() -> None:
    """Run the segmenter node."""
    _start('segmenter')


def locator() -> None:
    """Run the locator node."""
    _start('locator')


def pipeline() -> None:
    """Run camera, segmenter and locator in one process."""
    _start('pipeline')


def simulator() -> None:
    """Run the simulator node."""
    _start('simulator')


def _start(name: str) -> None:
    """Load a node and run it."""
    # Python's own handler would print where in the imports it was; rclpy puts in another later.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    import_module(f'blob_tracker.nodes.{name}').main()
