"""The executables: help without ROS, and a Ctrl-C that ends a node while it is loading."""

from collections.abc import Callable, Sequence
from functools import partial
import gc
from importlib import import_module
import os
import signal
import sys

from blob_tracker.nodes import NODES
from blob_tracker.nodes.help import help_text
from blob_tracker.nodes.interface import interface_of

WIDEST = 99  # columns: longer lines are hard to read
IMAGES = ('camera', 'simulator', 'pipeline')  # who publishes whole frames


def __getattr__(name: str) -> Callable[[], None]:
    """Return the function that runs a node of `NODES`: the entry points of setup.py ask for it."""
    if name in NODES:
        return partial(_start, name)
    raise AttributeError(f'no node {name}; there is {", ".join(NODES)}')


def _start(name: str) -> None:
    """Load a node and run it, or say what it is."""
    # Python's own handler would print where in the imports it was; rclpy puts in another later.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    gc.disable()  # until all is loaded, see ros/process.py
    words = sys.argv[1:]
    if '--ros-args' in words:  # what follows is rclpy's
        words = words[: words.index('--ros-args')]
    if '--help' in words or '-h' in words:
        import shutil  # which loads all that packs and unpacks

        columns = shutil.get_terminal_size((WIDEST, 0)).columns
        print(help_text(interface_of(name), min(columns, WIDEST)), flush=True)
        os._exit(0)  # to take down what was loaded takes as long as a tenth of it
    # A node has no matrices that are worth a second thread, and one that waits for them keeps
    # another core busy for a quarter of a second, in which others start.
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    from blob_tracker.ros.process import begin  # loads rclpy
    if code := begin(images=publishes_images(name, sys.argv)):
        sys.exit(code)
    from blob_tracker.kernel.notice import before_compiling  # loads NumPy
    before_compiling(_tell)
    import_module(f'blob_tracker.nodes.{name}').main()


def publishes_images(name: str, words: Sequence[str]) -> bool:
    """
    Tell whether a node publishes whole frames.

    Parameters
    ----------
    name : str
        Of `NODES`.
    words : sequence of str
        Its command line, as in sys.argv: the pipeline may be given the frames of others.

    """
    from blob_tracker.ros.parameters.given import sources
    given = {
        each.values['source'] for each in sources(words)
        if 'source' in each.values and each.is_for('/pipeline')
    } if name == 'pipeline' else set()
    return name in IMAGES and given != {'images'}


def _tell(sentence: str) -> None:
    """Say that kernels are compiled, which takes minutes: nobody need know the process yet."""
    from blob_tracker.ros.presence import leave
    leave()
    print(sentence, file=sys.stderr, flush=True)
