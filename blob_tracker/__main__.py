"""The command line: python3 -m blob_tracker COMMAND, which `COMMANDS` lists."""

from __future__ import annotations

import argparse
from importlib import import_module
import sys

COMMANDS = {
    'calibrate': ('blob_tracker.nodes.calibrate', 'measure a camera: lens, noise, line jitter'),
    'demo': ('blob_tracker.nodes.demo', 'track a simulated light, or a camera, and show it live'),
    'doctor': ('blob_tracker.nodes.doctor', 'say what is wrong with this machine, and what to do'),
    'optics': ('blob_tracker.studies.optics', 'what a lens sees and resolves, by its data sheet'),
    'replay': ('blob_tracker.nodes.replay', 'publish the messages of a bag, without ros2 bag'),
    'study': ('blob_tracker.studies.runner.command', "do the thesis' tables and figures again"),
}


def main(arguments: list[str] | None = None) -> int:
    """
    Run a command.

    Parameters
    ----------
    arguments : list of str, optional
        The words after `python3 -m blob_tracker`; those of this process where left out.

    Returns
    -------
    int
        Exit code: 0 done, 1 failed, 2 called wrongly.

    """
    parser = argparse.ArgumentParser(prog='python3 -m blob_tracker', description=__doc__)
    commands = parser.add_subparsers(dest='command', metavar='COMMAND', required=True)
    words = sys.argv[1:] if arguments is None else arguments
    if '--ros-args' in words:  # what follows is rclpy's, remappings say, which reads it itself
        words = words[: words.index('--ros-args')]
    for name, (module, summary) in COMMANDS.items():
        command = commands.add_parser(name, help=summary, description=summary)
        if words[:1] == [name]:  # only the command that runs is imported, with all it needs
            import_module(module).add_arguments(command)
    parsed = parser.parse_args(words)
    return int(import_module(COMMANDS[parsed.command][0]).main(parsed))


if __name__ == '__main__':
    sys.exit(main())
