"""Lights that blink and move on the real V4L2 driver: what guest_blink.py wrote down."""

from __future__ import annotations

import json
from typing import Any

from blob_tracker.segmentation import flash_by_name, Segmenter
from blob_tracker.simulation.waveforms import mean_over
from blob_tracker.types import Frame
import numpy as np
import pytest
from vm.hdmi_loop import SLOW_FRAME_RATE
from vm.scene import (
    BITS_PER_SECOND, BLINK_FRAMES, blinking_frames, blinking_lights, CODE, EXPOSURE, FREQUENCY,
    LIGHTS, PAUSE,
)

# px, of a light that is on for the whole exposure: sqrt of the variance of a dark pixel, 1.2 DN,
# and of the light's own, over the slope of a peak of 130 DN. One that is on for less has more.
SIGMA = 0.02
# Of the pictures in which the segmenter names a light on the host: a topic that is new loses the
# first place, and a busy machine some pictures on the way to those who record them.
SHARE = 0.4

pytestmark = pytest.mark.timeout(60, func_only=True)  # the boot is watched by itself


@pytest.fixture(scope='module')
def blink(results) -> dict[str, Any]:
    """Give what guest_blink.py found."""
    return json.loads((results / 'blink.json').read_text())


def lit(name: str, index: int) -> float:
    """Return for how much of the exposure a light is on in a picture."""
    times = np.array([index / SLOW_FRAME_RATE])
    return float(mean_over(blinking_lights()[name].waveform, times, EXPOSURE)[0])


def jitter(pictures: list[tuple[int, int]]) -> float:
    """Return by how much more than others the stamps of some pictures are late, s."""
    stamps, indices = np.array(pictures).T
    played = np.unwrap(indices, period=BLINK_FRAMES) / SLOW_FRAME_RATE
    # But for a few: what is played in an interval that the driver leaves out comes one later.
    return float(np.ptp(np.percentile((stamps - stamps[0]) / 1e9 - played, [5, 95])))


@pytest.mark.parametrize('name', LIGHTS)
def test_each_light_is_where_it_was_played(blink, name):
    shown = dict(blink['pictures'])
    known = [(shown[stamp], x, y) for stamp, x, y in blink['places'][name] if stamp in shown]
    assert len(known) > 5
    late = jitter(blink['pictures'])
    for index, x, y in known:
        at = index / SLOW_FRAME_RATE
        spot, later = (blinking_lights()[name].spot(time) for time in (at, at + late))
        # A stamp that is late has the light on for another part of the exposure.
        way = np.hypot(later.x - spot.x, later.y - spot.y)
        # Further than that is the other light, or a place in the dark.
        assert np.hypot(x - spot.x, y - spot.y) < (
            0.1 + 5 * SIGMA / max(lit(name, index), 0.05) + way)


def test_they_are_named_in_the_pictures_that_came(blink):
    segmenter = Segmenter(flash=flash_by_name(
        'coded', codes={'coded': CODE}, bits_per_second=BITS_PER_SECOND,
        frequencies={'free': FREQUENCY}, exposure=EXPOSURE, max_pair_interval=PAUSE,
    ))
    frames = blinking_frames()
    expected: dict[str, set[int]] = {name: set() for name in LIGHTS}
    for stamp, index in blink['pictures']:
        for sighting in segmenter.sightings(Frame(frames[index], stamp, 255)):
            expected[sighting.name].add(stamp)
    for name in LIGHTS:
        named = {place[0] for place in blink['places'][name]}
        assert len(expected[name]) > 5, name
        assert len(named & expected[name]) >= SHARE * len(expected[name]), name


def test_the_node_ends_without_a_trace(blink, results):
    code, _ = blink['exits']['pipeline']
    log = (results / 'blink.log').read_text()
    assert code == 0, log
    assert 'Traceback' not in log
