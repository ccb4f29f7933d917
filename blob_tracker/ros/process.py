"""The nodes of one process: start, spin, and leave without a trace."""

from __future__ import annotations

from collections.abc import Callable, Iterable
import gc
import sys

from blob_tracker.ros.errors import ParameterError
import rclpy
from rclpy.exceptions import NameValidationException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

WRONG_USE = 2  # exit code, as for a shell command called wrongly


def run(
    create: Callable[[], Iterable[Node]], prepare: Callable[[], None] = lambda: None
) -> int:
    """
    Run nodes until Ctrl-C or SIGTERM.

    Parameters
    ----------
    create : callable
        Makes the nodes, one after the other; they are destroyed in reverse.
    prepare : callable
        Long work before that. ROS is not yet there, so that a signal ends it at once.

    Returns
    -------
    int
        Exit code: 0, or 2 where the command line or a parameter is wrong, with a sentence on
        the standard error.

    """
    prepare()
    try:
        _initialise()
    except Exception as error:  # rclpy raises private types of its C layer here
        say(f'wrong ROS arguments: {error}')
        return WRONG_USE
    nodes: list[Node] = []
    try:
        try:
            for node in create():
                nodes.append(node)
        except (ParameterError, NameValidationException) as error:
            say(error)
            return WRONG_USE
        except RuntimeError as error:  # of rclpy's C layer: a QoS override that cannot be, say
            if not rclpy.ok():
                return 0
            say(f'the node cannot be made: {error}')
            return WRONG_USE
        # What is there now stays: no collection need look at it again.
        gc.collect()
        gc.freeze()
        executor = SingleThreadedExecutor()
        for node in nodes:
            executor.add_node(node)
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except ParameterError as error:  # only the camera knows what its controls may be
        say(error)
        return WRONG_USE
    except RuntimeError:  # of rclpy's C layer: the signal came between two of its calls
        if rclpy.ok():
            raise
    finally:
        for node in reversed(nodes):
            node.destroy_node()
        rclpy.try_shutdown()
    return 0


def say(what: object) -> None:
    """Print on the standard error; where its disk is full, tracking matters more than words."""
    try:
        print(what, file=sys.stderr, flush=True)
    except OSError:
        pass


def _initialise() -> None:
    """Start ROS; without log files where there is no place for them."""
    try:
        rclpy.init()
    except RuntimeError as error:
        if 'log directory' not in str(error):
            raise
        say(f'there are no log files, set ROS_LOG_DIR to a folder that can be written to: {error}')
        rclpy.try_shutdown()  # a context can be tried once
        rclpy.init(args=[*sys.argv, '--ros-args', '--disable-external-lib-logs'])
