"""
A process with the pipeline of a source tree, which notes when each bearing left for Fast DDS.

`python .../handed.py` in the folder of any tree: its own pipeline.py runs. Each frame of which
that tells has a fourth number: the monotonic time, ns, at which publish() of its bearing returned;
None if none was published.
"""

from __future__ import annotations

import ctypes
from importlib import import_module
import os
from runpy import run_module
from struct import unpack_from
import sys
import time
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher

SECOND_NS = 1_000_000_000  # ns
TRIM = ctypes.CDLL(None).malloc_trim


def _stamp_ns(message: Any) -> int:
    """Return the stamp of a message, or of its serialised form, ns."""
    if isinstance(message, bytes):  # CDR: four bytes about it, then the header with the stamp
        sec, nanosec = unpack_from('<iI', message, 4)
    else:
        sec, nanosec = message.header.stamp.sec, message.header.stamp.nanosec
    return int(sec * SECOND_NS + nanosec)


def main() -> None:
    """Run it."""
    sys.path[0] = os.getcwd()  # in place of the folder of this file
    source: Any = import_module('benchmarks.latency.source')
    handed: dict[int, int] = {}
    create, send = Node.create_publisher, source.send

    def created(self: Node, kind: Any, topic: str, *options: Any, **named: Any) -> Publisher:
        found = create(self, kind, topic, *options, **named)
        publish = found.publish

        def noted(message: Any) -> None:
            publish(message)
            handed[_stamp_ns(message)] = time.monotonic_ns()

        if topic.endswith('target/bearing'):
            found.publish = noted
        return found

    def sent(*asked: Any) -> list[tuple[int, int, bool, int | None]]:
        handed.clear()
        # The frames of the stream before are the benchmark's, and so is the room that they leave.
        TRIM(0)
        return [(*each, handed.get(each[0])) for each in send(*asked)]

    Node.create_publisher = created
    source.send = sent
    run_module('benchmarks.latency.pipeline', run_name='__main__', alter_sys=True)


if __name__ == '__main__':
    main()
