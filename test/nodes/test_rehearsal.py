"""What a lit frame needs is done just before it comes, and changes nothing of anybody's."""

from __future__ import annotations

from math import inf
import time
from types import SimpleNamespace
from typing import Any

from blob_tracker.capture import NoFrameError
from blob_tracker.nodes import rehearsal
from blob_tracker.nodes.camera import CameraNode, FRAME_TIMEOUT_S
from blob_tracker.nodes.rehearsal import LAST, LEAD_NS, Rehearsal, TimedRehearsal
from blob_tracker.nodes.segmenter import SegmenterNode
from blob_tracker.ros.endpoints.delivery import Delivery
from blob_tracker.segmentation import at_once, flash_memory
from blob_tracker.simulation import flashing_light
from blob_tracker.types import Frame
import pytest
import rclpy
from sensor_msgs.msg import CameraInfo
from support.processes import probe

INTERVAL_NS = 16_666_667  # of a camera at 60 Hz


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """Return a clock that stands still until it is set."""
    now = SimpleNamespace(ns=10**12)
    monkeypatch.setattr(time, 'monotonic_ns', lambda: now.ns)
    return now


def fed(clock: SimpleNamespace, interval_ns: int, count: int = LAST + 1) -> Rehearsal:
    """Return a rehearsal that has seen frames at this interval, the last one now."""
    made = Rehearsal(fits=True)
    for _ in range(count):
        clock.ns += interval_ns
        made.expect(clock.ns, 'B', True)
    return made


def test_it_is_due_before_the_next_frame(clock: SimpleNamespace) -> None:
    """So long before it as it takes, by the least interval of the last frames."""
    made = fed(clock, INTERVAL_NS)
    assert made.pause() == pytest.approx((INTERVAL_NS - LEAD_NS) / 1e9)
    clock.ns += INTERVAL_NS + 3_000_000
    made.expect(clock.ns, 'B', True)
    assert made.pause() == pytest.approx((INTERVAL_NS - LEAD_NS) / 1e9)
    clock.ns += INTERVAL_NS
    assert made.pause() == 0.0
    made.run()
    assert made.pause() == inf  # once a frame


@pytest.mark.parametrize('interval_ns', [2_000_000, 10**9])
def test_fast_and_slow_cameras_have_none(clock: SimpleNamespace, interval_ns: int) -> None:
    """The caches of the one are warm, and nobody knows when the other's next frame comes."""
    assert fed(clock, interval_ns).pause() == inf


def test_a_frame_that_will_be_dark_has_none(clock: SimpleNamespace) -> None:
    """The next one shows no light, and nobody waits for what comes of it."""
    made = fed(clock, INTERVAL_NS)
    made.expect(clock.ns + INTERVAL_NS, 'B', False)
    assert made.pause() == inf


@pytest.mark.parametrize('kind', ['B', 'H'])
@pytest.mark.parametrize('fits', [True, False])
def test_it_runs_through_all_that_a_lit_frame_does(
    kind: str, fits: bool, clock: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The light is found in each lit frame, the last one of a run, and placed where that is."""
    bearings: list[Any] = []
    monkeypatch.setattr(rehearsal, 'bearing_bytes', lambda *given: bearings.append(given))
    made = Rehearsal(fits=fits)
    made.expect(clock.ns, kind, True)
    for _ in range(12):
        made.run()
    pipeline, _ = made._kinds[kind]
    assert pipeline.segmenter.detections.state == 'locked'
    assert pipeline.segmenter.reason == pipeline.warning == ''
    assert len(bearings) == (12 if fits else 0)


def test_it_goes_the_way_of_a_followed_light(monkeypatch: pytest.MonkeyPatch) -> None:
    """In most frames; what else there is in the caches is of no use to a frame."""
    outcomes: list[int] = []

    def noted(*given: Any) -> Any:
        found = at_once.pair_at_once(*given)
        outcomes.append(found[0])
        return found

    monkeypatch.setattr(flash_memory, 'pair_at_once', noted)
    made = Rehearsal(fits=False)
    made.expect(0, 'B', True)
    for _ in range(100):
        made.run()
    late = outcomes[-120:]
    assert sum(each >= at_once.QUIET for each in late) > 0.8 * len(late)


def test_a_timer_runs_it_in_the_executor(domain: int) -> None:
    """Once after each frame, and not again by itself."""
    with probe(domain) as node:
        made = TimedRehearsal(node, fits=False)
        for index in range(3):
            made.expect((index + 1) * INTERVAL_NS, 'B', True)  # due long ago
            node.spin_until(lambda: made._count == 2 * (index + 1))
        node.spin(0.05)
    assert made._count == 6


def test_the_segmenter_expects_the_lit_frames(domain: int, clock: SimpleNamespace) -> None:
    """After each dark frame, once the light is in view; not where it is switched off."""
    scene = flashing_light(width=160, height=120, rate=60.0, period=30.0)
    rclpy.init(domain_id=domain)
    try:
        node = SegmenterNode(listen=False)
        due = []

        def show(index: int) -> None:
            clock.ns += INTERVAL_NS
            frame = Frame(scene.frame(index), clock.ns, 255)
            node.segment(Delivery((frame, CameraInfo()), 'optical'))

        for index in range(16):
            show(index)
            due.append(node.rehearsal.pause() < inf)
        assert due[-6:] == [False, True] * 3
        node._change({**_values(node), 'rehearse': False})()
        for index in range(16, 20):
            show(index)
            assert node.rehearsal.pause() == inf
        node.destroy_node()
    finally:
        rclpy.shutdown()


def test_the_camera_rehearses_while_it_waits() -> None:
    """In the thread that has the frame next."""
    done: list[str] = []
    ran = SimpleNamespace(
        pause=lambda: inf if done else 0.01, run=lambda: done.append('rehearsed')
    )

    def newest(timeout: float) -> str:
        done.append(f'waited {timeout:g}')
        if len(done) == 1:
            done.clear()
            raise NoFrameError('none')
        return 'frame'

    node: Any = SimpleNamespace(_ends=False, _rehearsal=ran)
    grabber: Any = SimpleNamespace(newest=newest)
    camera: Any = None
    assert CameraNode._next(node, camera, grabber) == 'frame'
    assert done == ['rehearsed', f'waited {FRAME_TIMEOUT_S:g}']


def _values(node: SegmenterNode) -> dict[str, Any]:
    """Return its parameters."""
    return {name: each.value for name, each in node._parameters.items()}
