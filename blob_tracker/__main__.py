"""The commands of blob_tracker; each has its own --help."""

from __future__ import annotations

from importlib import import_module
import os
from pathlib import Path
import sys
from types import ModuleType

from blob_tracker.commands import INSTALL_ROS
from blob_tracker.commands.exit_code import FAILED
from blob_tracker.commands.parser import Parser
from blob_tracker.kernel.notice import before_compiling

DEFAULT_CALL = 'python3 -m blob_tracker'
# Each is a module of `commands/` with `add_arguments` and `main`, imported only when it runs.
COMMANDS = {
    'calibrate': 'measure a camera, a light, a body of lights or a rig of cameras',
    'demo': 'track a simulated light, or a camera, and show it live',
    'doctor': 'say what is wrong with this machine, and what to do',
    'echo': 'print bearings as they come, without ros2 topic',
    'optics': 'what a lens sees and resolves, by its data sheet',
    'replay': 'publish the messages of a bag, without ros2 bag',
    'study': "do the thesis' tables and figures again",
    'track': 'from frames to bearings: of a video, images, a bag or a camera',
}


def command(name: str) -> ModuleType:
    """Return the module of a command of `COMMANDS`."""
    return import_module(f'blob_tracker.commands.{name}')


def main(arguments: list[str] | None = None) -> int:
    """
    Run a command.

    Parameters
    ----------
    arguments : list of str, optional
        The words after `python3 -m blob_tracker`; those of this process if left out.

    Returns
    -------
    int
        Exit code: 0 done, 1 failed or nobody reads what it prints, 2 called wrongly.

    """
    called = 'blob_tracker' if Path(sys.argv[0]).name == 'blob_tracker' else DEFAULT_CALL
    parser = Parser(prog=called, description=__doc__)
    commands = parser.add_subparsers(dest='command', metavar='COMMAND', required=True)
    words = sys.argv[1:] if arguments is None else arguments
    if '--ros-args' in words:  # what follows is rclpy's, remappings say, which reads it itself
        words = words[: words.index('--ros-args')]
    for name, summary in COMMANDS.items():
        subparser = commands.add_parser(name, help=summary, description=summary)
        if words[:1] == [name]:  # only the command that runs is imported, with all it needs
            try:
                command(name).add_arguments(subparser)
            except ModuleNotFoundError as error:
                print(_missing(name, error), file=sys.stderr)
                return 1
    parsed = parser.parse_args(words)
    before_compiling(lambda sentence: print(sentence, file=sys.stderr))
    try:
        code = int(command(parsed.command).main(parsed))
        sys.stdout.flush()
    except BrokenPipeError:
        # Or Python would try again, and complain, as it ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    return code


def _missing(name: str, error: ModuleNotFoundError) -> str:
    """Say what a command needs that is not there; all but ROS comes with the package."""
    module = str(error.name).partition('.')[0]
    if module == 'blob_tracker':
        raise error
    return f'{name} needs ROS 2, and {module} of it is not installed: {INSTALL_ROS}'


if __name__ == '__main__':
    sys.exit(main())
