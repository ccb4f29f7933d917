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
        rclpy.init()
    except Exception as error:  # rclpy raises private types of its C layer here
        print(f'wrong ROS arguments: {error}', file=sys.stderr)
        return WRONG_USE
    nodes: list[Node] = []
    try:
        try:
            for node in create():
                nodes.append(node)
        except (ParameterError, NameValidationException) as error:
            print(error, file=sys.stderr)
            return WRONG_USE
        except RuntimeError as error:  # of rclpy's C layer: a QoS override that cannot be, say
            if not rclpy.ok():
                return 0
            print(f'the node cannot be made: {error}', file=sys.stderr)
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
        print(error, file=sys.stderr)
        return WRONG_USE
    except RuntimeError:  # of rclpy's C layer: the signal came between two of its calls
        if rclpy.ok():
            raise
    finally:
        for node in reversed(nodes):
            node.destroy_node()
        rclpy.try_shutdown()
    return 0
