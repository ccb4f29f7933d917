"""
A node of a source tree that notes how long it has each message, from its arrival to the end.

`python .../taken.py segmenter` in the folder of any tree: its own node runs. To each line on its
standard input it answers with the times since the last one, us, from the callback that has an
image with its camera_info to where all that comes of it is published.
"""

from __future__ import annotations

from importlib import import_module
import json
import os
import sys
from threading import Thread
import time
from typing import Any


def main(name: str) -> Thread:
    """Run it; return the thread that answers."""
    sys.path[0] = os.getcwd()  # in place of the folder of this file
    node: Any = getattr(
        import_module(f'blob_tracker.nodes.{name}'), f'{name.capitalize()}Node'
    )
    take = node._take
    times: list[float] = []

    def taken(*given: Any) -> None:
        began_ns = time.perf_counter_ns()
        take(*given)
        times.append((time.perf_counter_ns() - began_ns) / 1e3)

    def answer() -> None:
        for _ in sys.stdin:
            count = len(times)
            print(json.dumps(times[:count]), flush=True)
            del times[:count]

    node._take = taken
    answering = Thread(target=answer, daemon=True)
    answering.start()
    getattr(import_module('blob_tracker.nodes.start'), name)()
    return answering


if __name__ == '__main__':
    main(sys.argv.pop(1))
