"""
Runs in the guest: its scripts one after the other, each a fork of a Python that has all loaded.

Usage: python -m vm.guest FOLDER SCRIPT...
A script is a module of this folder with a function `main`, which gets FOLDER.
"""

from __future__ import annotations

from functools import partial
import gc
from importlib import import_module
from pathlib import Path
import sys
import time

from blob_tracker.nodes import pipeline
from vm.fork import Fork


def main(folder: Path, scripts: list[str]) -> None:
    """Do all of them, up to the first that fails."""
    pipeline.compile_all()
    actions = {name: partial(import_module(f'vm.{name}').main, folder) for name in scripts}
    gc.collect()
    gc.freeze()  # the forks share it
    for name, action in actions.items():
        began = time.monotonic()
        code = Fork(action).begin().wait()
        print(f'{name}: {time.monotonic() - began:.1f} s', flush=True)
        if code:
            sys.exit(code)


if __name__ == '__main__':
    main(Path(sys.argv[1]), sys.argv[2:])
