"""The nodes of one process: start, spin, and leave without a trace."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
import gc
import inspect
import sys
from types import ModuleType

from blob_tracker.ros import presence
from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.parameters.given import no_yaml, remarks, sources, unreadable
import rclpy
from rclpy.context import Context
from rclpy.exceptions import (
    NameValidationException, NotInitializedException, ParameterException,
)
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.logging import LoggingSeverity
from rclpy.node import Node
from rclpy.signals import install_signal_handlers, SignalHandlerOptions
from rclpy.task import Future

try:
    from rclpy.experimental import EventsExecutor
except ImportError:  # rclpy before 7.1.4
    EventsExecutor = None

WRONG_USE = 2  # exit code, as for a shell command called wrongly
SPELL_S = 10.0  # s; the plain executor adds a little to its future with each callback


def begin(*, images: bool = True) -> int:
    """
    Start ROS, and let other processes discover this one while it loads the rest.

    Parameters
    ----------
    images : bool
        Whether it publishes whole frames, see `presence.announce`.

    Returns
    -------
    int
        Exit code, as that of `run`: 0 to go on.

    """
    if fault := unreadable(sys.argv):  # rcl would name lines of its own source
        say(fault)
        return WRONG_USE
    try:
        _initialise()
    except Exception as error:  # rclpy raises private types of its C layer here
        say(f'wrong ROS arguments: {error}{_remedy(str(error))}')
        return WRONG_USE
    presence.announce(images=images)
    return 0


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
        Long work before that. A signal ends it at once.

    Returns
    -------
    int
        Exit code: 0, or 2 where the command line or a parameter is wrong, with a sentence on
        the standard error.

    """
    if not rclpy.ok() and (code := begin()):
        return code
    prepare()
    # What has been loaded stays: no collection need look at it again. None ran meanwhile, see
    # nodes/start.py; what one would find now is less than it costs to look.
    gc.freeze()
    know_who_logs()
    presence.settle()
    install_signal_handlers(SignalHandlerOptions.ALL)
    nodes: list[Node] = []
    executor: Executor | None = None
    try:
        try:
            for node in create():
                nodes.append(node)
        except (ParameterError, NameValidationException, ParameterException) as error:
            say(error)
            return WRONG_USE
        # Of rclpy's C layer: a QoS override that cannot be, say.
        except (RuntimeError, NotInitializedException) as error:
            if not rclpy.ok():  # a signal came
                return 0
            say(f'the node cannot be made: {error}')
            return WRONG_USE
        presence.withdraw()
        _say_remarks(nodes)
        gc.freeze()
        gc.enable()
        if not rclpy.ok():  # a signal came: no executor can be made any more
            return 0
        executor = _executor(nodes)
        for node in nodes:
            executor.add_node(node)
        while rclpy.ok():
            # Not spin(): that of the EventsExecutor of rclpy 7.1 waits for a time that overflows
            # and calls nobody back. This way both executors work.
            executor.spin_until_future_complete(Future(), SPELL_S)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except ParameterError as error:  # only the camera knows what its controls may be
        say(error)
        return WRONG_USE
    except RuntimeError:  # of rclpy's C layer: the signal came between two of its calls
        if rclpy.ok():
            raise
    finally:
        for node in nodes:  # or rcl complains of each word that cannot be published any more
            node.get_logger().set_level(LoggingSeverity.FATAL)
        if executor is not None:
            executor.shutdown()  # or the middleware would call into what is destroyed next
        for node in reversed(nodes):
            node.destroy_node()
        presence.withdraw()
        shut_down()
    return 0


def shut_down(context: Context | None = None) -> None:
    """Leave ROS, unless a signal does: it may come between rclpy's look and its step."""
    with suppress(RuntimeError):
        rclpy.try_shutdown(context=context)


def know_who_logs() -> None:
    """
    Tell `inspect` the files of all modules, among which rclpy looks for who logs.

    With the first line that is logged it would resolve each of them, for 20 to 50 ms of a fault.
    """
    for name, module in list(sys.modules.items()):
        path = vars(module).get('__file__') if isinstance(module, ModuleType) else None
        if path is not None:
            inspect.modulesbyfile[path] = name


def _executor(nodes: Iterable[Node]) -> Executor:
    """
    Return the executor that takes a message in the least time.

    The EventsExecutor takes half the processor time of the plain one for a message, which asks
    each service, timer and event of the node in Python every time, and 0.1 to 0.2 ms less from
    hand to hand. It has no guard conditions, which the camera's node needs, whose frames do not
    pass through an executor. It does not survive that a publisher or subscription is destroyed
    while it spins (an event of it may be on the way): so the nodes keep theirs to the end.
    """
    if EventsExecutor is None or any(list(node.guards) for node in nodes):
        return SingleThreadedExecutor()
    return EventsExecutor()


def _say_remarks(nodes: Sequence[Node]) -> None:
    """Say what of the command line has no effect on any of the nodes."""
    values = {
        node.get_fully_qualified_name(): {
            name: each.value for name, each in node._parameter_overrides.items()
        }
        for node in nodes
    }
    for sentence in remarks(list(sources(sys.argv)), values) if nodes else ():
        nodes[0].get_logger().warning(sentence)


def _remedy(error: str) -> str:
    """Return what to do about a fault in the command line that rcl does not tell."""
    if 'No value at line' in error or 'error not set' in error:
        return "; a parameter needs a value: '' is the empty text, and left out it has its default"
    if 'before ros__parameters' in error:
        return '; a file begins with /**: or the name of a node, below it ros__parameters:'
    if 'Sequence' in error:
        return "; no value is a list of lists or of several kinds: names are one text, 'a,b'"
    for what, rule in (('parameter override', '-p NAME:=VALUE'), ('remap', '-r OLD:=NEW')):
        if f'parse {what} rule' in error:
            return f'; write {rule}'
    if fault := no_yaml(sys.argv):
        return f'; {fault}'
    return ''


def say(what: object) -> None:
    """Print on the standard error; where its disk is full, tracking matters more than words."""
    try:
        print(what, file=sys.stderr, flush=True)
    except OSError:
        pass


def _initialise() -> None:
    """Start ROS; without log files if there is no place for them."""
    try:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:
        if 'log directory' not in str(error):
            raise
        say(f'there are no log files, set ROS_LOG_DIR to a folder that can be written to: {error}')
        shut_down()  # a context can be tried once
        rclpy.init(
            args=[*sys.argv, '--ros-args', '--disable-external-lib-logs'],
            signal_handler_options=SignalHandlerOptions.NO,
        )
