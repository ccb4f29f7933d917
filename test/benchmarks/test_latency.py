"""Ways of frames: what is lost and what a ratio is, and one that is really walked."""

from __future__ import annotations

from collections.abc import Sequence
import json
import os
from pathlib import Path
import subprocess
import sys
from threading import Event
from types import ModuleType, SimpleNamespace
from typing import Any, cast

from benchmarks import latency
from benchmarks.latency import beside, many, taken
from benchmarks.latency.figures import (
    Figures, LARGE, ONE, Resident, Row, SMALL, Start, THREE, USUAL,
)
from benchmarks.latency.nodes import STARTED
from benchmarks.latency.process import Process, ROOT
from benchmarks.latency.source import draw
from benchmarks.report import Report
from benchmarks.tables_of_running import beside as beside_table
from benchmarks.targets import judge
from blob_tracker import segmentation
from blob_tracker.nodes import start
from blob_tracker.types import Frame
import numpy as np
import pytest

MS = 1_000_000  # ns


def _stream(
    delays_ms: Sequence[float], *, lost: int = 0, handed_ms: Sequence[float] = ()
) -> latency.Stream:
    delays = np.array(delays_ms) / 1e3
    busy = {'node': 0.1 * len(delays)}
    return latency.Stream(delays, len(delays) + lost, busy, np.array(handed_ms) / 1e3)


def test_delays_are_those_of_the_lit_frames_after_the_first_second() -> None:
    """The stamp says which frame an answer is to; an answer that never came is a loss."""
    sent = [(place, place * 500 * MS, place % 2 == 0) for place in range(8)]  # 2 Hz
    arrived = [(0, 9 * MS), (2, 1007 * MS), (3, 1600 * MS), (6, 3002 * MS)]
    found = latency.pair(sent, arrived, lit_alone=True)
    assert found.delays.tolist() == [0.007, 0.002]
    assert (found.expected, found.lost) == (3, 1)
    assert latency.pair(sent, arrived, lit_alone=False).expected == 6
    assert not found.handed.size


def test_bearings_are_handed_over_before_they_arrive() -> None:
    """Their time is told by the process that publishes them, of the frames that count."""
    sent = [
        (place, place * 500 * MS, place % 2 == 0, None if place % 4 else (place * 500 + 1) * MS)
        for place in range(10)
    ]
    found = latency.pair(sent, [(4, 2003 * MS), (8, 4005 * MS)], lit_alone=True)
    assert found.delays.tolist() == [0.003, 0.005]
    assert found.handed.tolist() == [0.001, 0.001]


def test_ratios_are_taken_round_by_round() -> None:
    """A round in which the machine is slow is slow for both, and does not count more."""
    ours = [_stream([4.0]), _stream([44.0], lost=2), _stream([6.0])]
    hops = [[_stream([1.0]), _stream([10.0]), _stream([1.0])]] * 2
    row = latency.row(THREE, USUAL, 60.0, ours, hops)
    assert row.over_hops == pytest.approx(2.2)  # of 2, 2.2 and 3
    assert (row.lost, row.expected) == (2, 5)
    assert row.busy == {'node': pytest.approx(0.1)}
    assert np.isnan(latency.row(THREE, USUAL, 60.0, ours).over_hops)


def test_a_round_in_which_nothing_came_is_no_good_one() -> None:
    """It misses its targets: NaN is not met."""
    row = latency.row(THREE, USUAL, 60.0, [_stream([], lost=3)], [[_stream([1.0])]])
    assert np.isnan(row.over_hops) and row.lost == row.expected == 3


def test_targets() -> None:
    """Each is decided by its own figure."""
    def row(way: str, size: tuple[int, int], rate: float, **figures: Any) -> Row:
        return Row(way, size, rate, [2e-3], [4e-3], 5e-3, **{'expected': 100, **figures})

    figures = Figures(
        [
            row(THREE, USUAL, 60.0, over_hops=1.3, tails_over_hops=2.1),
            row(ONE, USUAL, 60.0, over_hops=1.5, tails_over_hops=9.0),
            row(THREE, USUAL, 300.0, lost=1),
            row(ONE, USUAL, 500.0, busy={'pipeline': 0.61}),
            row(THREE, LARGE, 60.0),
            row(ONE, LARGE, 60.0, busy={'pipeline': 0.29}),
        ],
        [Start(THREE, [2.0, 9.0, 2.5]), Start(ONE, [3.5])],
        [Resident('segmenter', 299.0, 199.0, 0.0, 0.0, 0), Resident('locator', 240, 201, 0, 0, 0)],
    )
    judged = {(each.name, each.where): each for each in judge(Report(latency=figures), [])}
    missed = {name for (name, _), each in judged.items() if not each.met}
    assert missed == {
        'the same at the 99th percentile',
        'frame in hand to bearing elsewhere, one process, over one bare hop',
        'bearings lost, three processes, 640 x 480 at 300 Hz',
        'one process, 640 x 480 at 500 Hz, of one core',
        'memory of a node, without the files that all nodes share',
        'start to first bearing',
    }
    assert judged['start to first bearing', THREE].met


def test_two_source_trees_take_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each comes first in every other round, and the ratios are those of the rounds."""
    order: list[Path] = []

    class Alike:
        """Nodes of which those beside take twice as long, in rounds of their own."""

        def __init__(self, _: object, tick: object, root: Path, *, timed: bool) -> None:
            self._root, self._factor = root, 1 + (root != ROOT)
            self._walks = 0

        def walk(self, way: str, *_: object) -> latency.Stream:
            order.append(self._root)
            self._walks += 1
            delays = [float(self._factor * self._walks)] * beside.FEWEST
            return _stream(delays, handed_ms=delays[:2] if way == ONE else [])

        def proportional_memory(self) -> dict[str, float]:
            return {'pipeline': 100.0 * self._factor}

        def own_times(self) -> dict[str, list[float]]:
            times = [100.0 * self._factor] * (beside.FIRST + 2)
            return {'segmenter': times, 'locator': times}

    def first_bearing(way: str, root: Path) -> float:
        return 2.0 if root == ROOT else 4.0

    def cost(root: Path) -> float:
        return 0.2 if root == ROOT else 0.4

    compiled: list[Path] = []
    monkeypatch.setattr(beside, 'Nodes', Alike)
    monkeypatch.setattr(beside, 'first_bearing', first_bearing)
    monkeypatch.setattr(beside, 'help_time', cost)
    monkeypatch.setattr(beside, 'many_lights', lambda root: [cost(root), cost(root)])
    monkeypatch.setattr(subprocess, 'run', lambda *_, cwd, **__: compiled.append(cwd))
    ticks: list[str] = []
    plan = latency.Plan(rounds=2, seconds=1.0, starts=3)
    other = ROOT.parent / 'other'
    figures = latency.run(plan, ticks.append, other)
    assert compiled == [ROOT, other]
    walks = len(beside.WALKS)
    assert order == [ROOT, other] * walks + [other, ROOT] * walks
    assert len(ticks) == latency.steps(plan, other)
    # As much of a core, which is the number of its answers in these streams.
    assert {each.ratio for each in figures.beside if each.unit != '%'} == {0.5}
    assert not judge(Report(latency=figures), [])
    late = [each.what for each in figures.beside if each.what.endswith('p99.9')]
    assert len(late) == walks and not any('hand' in each for each in late)  # two are too few
    handed = [each for each in figures.beside if 'in the hand of DDS' in each.what]
    assert len(handed) == 2 * sum(each.way == ONE for each in beside.WALKS)
    assert beside_table(figures.beside).row_count == len(figures.beside)


def test_the_light_flashes_in_step_and_never_jumps() -> None:
    """From the last frame of a turn to the first it moves as far as within it."""
    turn = draw(64, 48, 60.0)
    middles = [np.unravel_index(np.argmax(lit), lit.shape) for lit in turn[::2]]
    unlit = [int(dark.max()) for dark in turn[1::2]]
    steps = np.abs(np.diff([*middles, middles[0]], axis=0))
    assert len(turn) % 2 == 0 and steps.max() <= 1
    assert max(unlit) < min(int(lit.max()) for lit in turn[::2])


def test_a_bare_hop_is_walked() -> None:
    """Real processes over the real middleware: images arrive, later than they were sent."""
    found = latency.hop(SMALL, 20.0, 0.5, warm_up=0.1)
    assert 0 < len(found.delays) <= found.expected <= 11  # best effort: a busy machine may lose
    assert found.delays.min() > 0.0


def test_a_process_that_fails_says_why() -> None:
    """What it wrote is in the error."""
    with Process('camera', 'no json') as process, pytest.raises(RuntimeError, match='JSON'):
        process.answer()


def test_a_node_of_any_tree_is_timed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """From where it has a message to where it is done with it, since the last question."""
    done = Event()

    class NewNode:
        def _take(self, image: str) -> None:
            done.wait(0.01)

    def new() -> None:
        NewNode()._take('image')
        asked.write('"new"\n')
        asked.close()

    out, to = os.pipe()
    asked = os.fdopen(to, 'w')
    with os.fdopen(out) as questions:
        monkeypatch.setattr(sys, 'stdin', questions)
        monkeypatch.setattr(sys, 'path', list(sys.path))
        module = cast(ModuleType, SimpleNamespace(NewNode=NewNode))
        monkeypatch.setitem(sys.modules, 'blob_tracker.nodes.new', module)
        monkeypatch.setattr(start, 'new', new, raising=False)
        answering = taken.main('new')
        answering.join()
    (time,) = json.loads(capsys.readouterr().out)
    assert time >= 10_000.0  # us


def test_a_start_loads_no_benchmark() -> None:
    code = (
        'import runpy, sys\n'
        f"sys.argv = [{STARTED!r}, 'segmenter', '--help']\n"
        f"runpy.run_path({STARTED!r}, run_name='__main__')\n"
        "assert not [name for name in sys.modules if name.startswith('benchmarks')]\n"
    )
    found = subprocess.run(
        [sys.executable, '-c', code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert 'segmenter' in found.stdout


def test_many_lights_are_found() -> None:
    """All sixteen codes by their names, and nearly all stars of the sky."""
    segmenter, images = many._coded(segmentation)
    names = set()
    for index in range(3 * many.BITS):
        frame = Frame(images[index % len(images)], round(1e9 * index / many.RATE), 255)
        names |= {each.name for each in segmenter.sightings(frame)}
    assert len(names) == many.LIGHTS
    segmenter, images = many._stars(segmentation)
    segmenter.sightings(Frame(images[0], 1, 255))
    assert len(segmenter.detections.candidates) > 0.8 * many.STARS  # some touch each other
