"""Everything that one run has measured."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from benchmarks import (
    accuracy, bearing, blink, body, capture, detection, files, lab, latency, motion, pose,
    real_frames, real_pixels, search, speed, tracking, triangulation, world,
)
from benchmarks.accuracy import Bias, Row
from benchmarks.bearing import Row as BearingRow
from benchmarks.blink import Row as BlinkRow
from benchmarks.body import Row as BodyRow
from benchmarks.capture import Row as CaptureRow
from benchmarks.contender import Contender
from benchmarks.detection import Counts, Row as DetectionRow
from benchmarks.files import Row as FileRow
from benchmarks.lab import Row as LabRow
from benchmarks.motion import Row as MotionRow
from benchmarks.pose import Row as PoseRow
from benchmarks.real_frames import Row as FrameRow
from benchmarks.real_pixels import Row as RealRow
from benchmarks.search import Row as SearchRow
from benchmarks.speed import Pace
from benchmarks.triangulation import Row as TriangulationRow
from benchmarks.world import Row as WorldRow

PARTS = ('accuracy', 'speed', 'real', 'detection', 'search', 'motion', 'tracking', 'capture',
         'latency', 'world', 'blink', 'files', 'pose', 'triangulation')


@dataclass(frozen=True)
class Sizes:
    """
    How much is measured.

    Windows a scene, phase, lens and stack; repeats of the timing; frames of the clutter scenes
    and of the moving camera; length of a vehicle's ride, s; rounds and starts of the latency;
    flashes of each situation outside the lab; frames and paths of the blinking lights; sights of
    a body, and of a light by several cameras.
    """

    scene: int
    phase: int
    bearing: int
    stack: int
    repeats: int
    detection: Counts
    motion: int
    tracking: float
    latency: latency.Plan
    world: int
    blink: blink.Size
    pose: int
    triangulation: int


FULL = Sizes(
    scene=10_000, phase=400, bearing=2_000, stack=10_000, repeats=7,
    detection=detection.FULL, motion=1_200, tracking=120.0, latency=latency.FULL,
    world=world.FULL, blink=blink.FULL, pose=2_000,
    triangulation=4_000,
)
QUICK = Sizes(
    scene=1_000, phase=60, bearing=500, stack=2_000, repeats=3,
    detection=detection.QUICK, motion=100, tracking=30.0, latency=latency.QUICK,
    world=world.QUICK, blink=blink.QUICK, pose=300,
    triangulation=2_000,
)


@dataclass(frozen=True)
class Report:
    """The rows of each part; empty if the part was not asked for."""

    accuracy: list[Row] = field(default_factory=list)
    bias: list[Bias] = field(default_factory=list)
    bearing: list[BearingRow] = field(default_factory=list)
    speed: list[Pace] = field(default_factory=list)
    lab: list[LabRow] = field(default_factory=list)
    real: list[RealRow] = field(default_factory=list)
    frames: list[FrameRow] = field(default_factory=list)
    detection: list[DetectionRow] = field(default_factory=list)
    search: list[SearchRow] = field(default_factory=list)
    motion: list[MotionRow] = field(default_factory=list)
    tracking: tracking.Figures = tracking.Figures()
    capture: list[CaptureRow] = field(default_factory=list)
    latency: latency.Figures = latency.Figures()
    world: list[WorldRow] = field(default_factory=list)
    blink: list[BlinkRow] = field(default_factory=list)
    files: list[FileRow] = field(default_factory=list)
    pose: list[PoseRow] = field(default_factory=list)
    body: list[BodyRow] = field(default_factory=list)
    triangulation: list[TriangulationRow] = field(default_factory=list)


def steps(parts: Collection[str], sizes: Sizes, beside: Path | None = None) -> int:
    """Return how often `measure` reports what it is at."""
    each = {
        'accuracy': accuracy.steps() + bearing.steps(),
        'speed': speed.steps() + lab.steps(),
        'real': 3,
        'detection': detection.steps(),
        'search': search.steps(),
        'motion': motion.steps(),
        'tracking': tracking.steps(),
        'capture': capture.steps(),
        'latency': latency.steps(sizes.latency, beside),
        'world': world.steps(),
        'blink': blink.steps(),
        'files': files.steps(),
        'pose': pose.steps() + body.steps(),
        'triangulation': triangulation.steps(),
    }
    return sum(each[part] for part in parts)


def measure(
    parts: Collection[str],
    contenders: Sequence[Contender],
    sizes: Sizes,
    data: Path | None,
    tick: Callable[[str], None],
    seed: int = world.SEED,
    beside: Path | None = None,
    load: bool = False,
) -> Report:
    """
    Measure the parts that are named.

    `data` is the folder of the real pixels, `seed` that of the situations outside the lab,
    `beside` the source tree beside whose nodes those of this one are measured, if any, and
    `load` says whether another process keeps a core busy meanwhile.
    """
    report = Report()
    if 'accuracy' in parts:
        report.accuracy.extend(accuracy.run(contenders, sizes.scene, tick))
        report.bias.extend(accuracy.run_bias(contenders, sizes.phase, tick))
        report.bearing.extend(bearing.run(sizes.bearing, tick))
    if 'speed' in parts:
        report.speed.extend(speed.run(contenders, sizes.stack, sizes.repeats, tick))
        report.lab.extend(lab.run(sizes.repeats, tick))
    if 'real' in parts and data is not None:
        report.real.extend(real_pixels.run(contenders, data, tick))
        tick('real frames')
        report.frames.extend(real_frames.run(data))
    if 'detection' in parts:
        report.detection.extend(detection.run(sizes.detection, tick))
    if 'search' in parts:
        report.search.extend(search.run(sizes.repeats, tick))
    if 'motion' in parts:
        report.motion.extend(motion.run(sizes.motion, tick))
    if 'tracking' in parts:
        found = tracking.run(sizes.tracking, sizes.repeats, tick)
        report = replace(report, tracking=found)
    if 'capture' in parts:
        report.capture.extend(capture.run(sizes.repeats, tick))
    if 'latency' in parts:
        report = replace(report, latency=latency.run(sizes.latency, tick, beside, load=load))
    if 'world' in parts:
        report.world.extend(world.run(sizes.world, tick, seed))
    if 'blink' in parts:
        report.blink.extend(blink.run(sizes.blink, tick))
    if 'files' in parts:
        report.files.extend(files.run(sizes.repeats, tick))
    if 'pose' in parts:
        report.pose.extend(pose.run(sizes.pose, tick))
        report.body.extend(body.run(sizes.pose, tick))
    if 'triangulation' in parts:
        report.triangulation.extend(triangulation.run(sizes.triangulation, tick))
    return report
