"""
Runs in the guest: its scripts, each a fork of a Python that has all loaded.

Usage: python -m vm.guest FOLDER STAGE...
A script is a module of this folder with a function `main`, which gets FOLDER. A stage begins when
the one before has ended: scripts that run one after the other, as A,B,C, or several such rows
beside each other, as A,B/C.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
import gc
from importlib import import_module
from pathlib import Path
import re
import sys
import time

from blob_tracker.nodes import pipeline
from vm.fork import Fork


def main(folder: Path, stages: list[str]) -> None:
    """Do all of them, up to the first that fails."""
    pipeline.compile_all()
    actions = {
        name: partial(import_module(f'vm.{name}').main, folder)
        for name in re.findall(r'\w+', ' '.join(stages))}
    gc.collect()
    gc.freeze()  # the forks share it
    for stage in stages:
        rows = [Fork(partial(run, actions, row.split(','))) for row in stage.split('/')]
        for row in rows:
            row.begin()
        code = max([row.wait() for row in rows], key=abs)
        if code:
            sys.exit(code)


def run(actions: Mapping[str, Callable[[], object]], names: Sequence[str]) -> None:
    """Do some one after the other, up to the first that fails."""
    for name in names:
        began = time.monotonic()
        code = Fork(actions[name]).begin().wait()
        print(f'{name}: {time.monotonic() - began:.1f} s', flush=True)
        if code:
            sys.exit(code)


if __name__ == '__main__':
    main(Path(sys.argv[1]), sys.argv[2:])
