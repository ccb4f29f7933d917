"""One node in one process: start, spin, and leave without a trace."""

from __future__ import annotations

from collections.abc import Callable
import sys

from blob_tracker.ros.errors import ParameterError
import rclpy
from rclpy.exceptions import NameValidationException
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

WRONG_USE = 2  # exit code, as for a shell command called wrongly


def run(create: Callable[[], Node], prepare: Callable[[], None] = lambda: None) -> int:
    """
    Run a node until Ctrl-C or SIGTERM.

    Parameters
    ----------
    create : callable
        Makes the node.
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
    node = None
    try:
        try:
            node = create()
        except (ParameterError, NameValidationException) as error:
            print(error, file=sys.stderr)
            return WRONG_USE
        except RuntimeError as error:  # of rclpy's C layer: a QoS override that cannot be, say
            if not rclpy.ok():
                return 0
            print(f'the node cannot be made: {error}', file=sys.stderr)
            return WRONG_USE
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except ParameterError as error:  # only the camera knows what its controls may be
        print(error, file=sys.stderr)
        return WRONG_USE
    except RuntimeError:  # of rclpy's C layer: the signal came between two of its calls
        if rclpy.ok():
            raise
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0
