"""
Draw where the time of a frame goes, function by function, in this source tree and in another.

`python tools/flame_graph.py folder docs/flame_graph.svg`; the folder is that of another source
tree, a git worktree of another commit, say. Each tree's own benchmarks/latency/pipeline.py has its
nodes, which are given frames at 500 Hz in the main thread, where a timer looks at them.
"""

from __future__ import annotations

from collections import Counter
from html import escape
from importlib import import_module
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time
from types import FrameType
from typing import Any

ROOT = Path(__file__).parents[1]
RATE, SECONDS, WARM_UP = 500.0, 20.0, 4.0  # Hz, s, s
PERIOD = 0.00047  # s between two looks: a part of a frame's interval would see the same places
ENTRY = 'segment'  # the function that is given a frame
WIDTH, ROW, LEFT, LETTER = 1200, 16, 4, 6.2  # px
DEEPEST = 16  # rows
NARROWEST = 2.0  # px, below which a function is left out
Stacks = dict[str, float]  # us by the names of the functions, the outermost first


def sampled() -> Stacks:
    """Return the time of a lit frame and the unlit one after it, of the tree in this folder."""
    sys.path[0] = os.getcwd()
    import rclpy

    rclpy.init()
    module: Any = import_module('benchmarks.latency.pipeline')
    module.compile_all()
    linked = getattr(module, 'linked_nodes', None) or module.nodes
    nodes = list(linked())
    module.report = lambda sent: counted.append(len(sent))
    counted: list[int] = []
    stacks: Counter[str] = Counter()

    def look(_: int, frame: FrameType | None) -> None:
        names: list[str] = []
        while frame is not None and frame.f_code.co_name != ENTRY:
            code = frame.f_code
            names.append(f'{Path(code.co_filename).stem}.{code.co_name}')
            frame = frame.f_back
        if frame is not None:
            stacks[';'.join([ENTRY, *reversed(names)])] += 1

    stream: Any = nodes[-1]._stream_once
    stream(640, 480, RATE, WARM_UP)
    signal.signal(signal.SIGALRM, look)
    signal.setitimer(signal.ITIMER_REAL, PERIOD, PERIOD)
    began = time.monotonic()
    stream(640, 480, RATE, SECONDS)
    lasted = time.monotonic() - began
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    looks, pairs = lasted / PERIOD, counted[-1] / 2.0
    return {name: 1e6 * lasted * count / looks / pairs for name, count in stacks.items()}


def drawn(panels: dict[str, Stacks]) -> str:
    """Return the SVG of several measurements, one below the other on one scale."""
    scale = (WIDTH - 2 * LEFT) / max(sum(each.values()) for each in panels.values())
    parts, top = [], 0.0
    for title, stacks in panels.items():
        parts.append(
            f'<text x="{LEFT}" y="{top + 18:.0f}" font-weight="bold">{escape(title)}: '
            f'{sum(stacks.values()):.0f} us</text>'
        )
        boxes, rows = _boxes(stacks, scale, top + 26.0)
        parts += boxes
        top += 26.0 + ROW * rows + 14.0
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {top:.0f}" '
        'font-family="monospace" font-size="10">\n'
        f'<rect width="{WIDTH}" height="{top:.0f}" fill="white"/>\n' + '\n'.join(parts)
        + '\n</svg>\n'
    )


def _boxes(stacks: Stacks, scale: float, top: float) -> tuple[list[str], int]:
    """Return the boxes of one measurement, callers above what they call, and how many rows."""
    found, rows = [], 0
    level = [('', 0.0, {tuple(name.split(';')): us for name, us in stacks.items()})]
    while level and rows < DEEPEST:
        below = []
        for _, at, inside in level:
            functions: dict[str, dict[tuple[str, ...], float]] = {}
            for (name, *rest), us in inside.items():
                functions.setdefault(name, {})[tuple(rest)] = us
            for name, its in sorted(functions.items(), key=lambda each: -sum(each[1].values())):
                us = sum(its.values())
                if us * scale >= NARROWEST:
                    found.append(_box(name, us, at, scale, top + ROW * rows))
                    below.append((name, at, {rest: us for rest, us in its.items() if rest}))
                at += us
        level = below
        rows += bool(below)
    return found, rows


def _box(name: str, us: float, at: float, scale: float, y: float) -> str:
    x, width = LEFT + at * scale, us * scale
    hue = sum(map(ord, name.partition('.')[0])) * 37 % 360  # of the file
    letters = int((width - 4.0) / LETTER)
    short = name if len(name) <= letters else name.rpartition('.')[2][:letters]
    words = f'<text x="{x + 2:.1f}" y="{y + 11:.0f}">{escape(short)}</text>' if short else ''
    return (
        f'<g><title>{escape(name)}: {us:.1f} us</title><rect x="{x:.1f}" y="{y:.0f}" '
        f'width="{width:.1f}" height="{ROW - 1}" fill="hsl({hue},60%,78%)"/>{words}</g>'
    )


def measured(tree: Path) -> Stacks:
    """Return what `sampled` finds in another process."""
    reads, writes = os.pipe()  # the nodes end with their standard input
    try:
        said = subprocess.check_output(
            [sys.executable, __file__], cwd=tree, stdin=reads, text=True,
            env=dict(os.environ, PYTHONPATH=str(tree), ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST'),
        )
    finally:
        os.close(reads)
        os.close(writes)
    found: Stacks = json.loads(said.splitlines()[-1])
    return found


def main() -> None:
    """Measure and draw; or, without arguments, measure the tree in this folder."""
    if len(sys.argv) < 3:
        print(json.dumps(sampled()), flush=True)
        os._exit(0)  # a thread of the nodes' still waits for the standard input
    other = Path(sys.argv[1]).resolve()
    Path(sys.argv[2]).write_text(drawn({
        f'{name}, a lit frame and the unlit one after it': measured(tree)
        for name, tree in (('Before', other), ('Now', ROOT))
    }))


if __name__ == '__main__':
    main()
