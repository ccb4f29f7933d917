"""Lights that blink and move on the real V4L2 driver: what guest_blink.py wrote down."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from vm.hdmi_loop import FRAME_RATE
from vm.scene import BLINK_FRAMES, blinking_lights

# px off the path: glimpses of a tenth of an exposure at 5 px a frame, which the loop showed in
# another frame than was due. The lights are 30 px apart and more.
TOLERANCE = 0.4
# Of the places: a busy machine loses four frames of five, and a light may be taken for the other.
RIGHT = 0.9
# s between two places, in which the player of a busy machine does not pause for long.
NEAR = 2.5
LIGHTS = 'coded', 'free'

pytestmark = pytest.mark.timeout(60, func_only=True)  # the boot is watched by itself


@pytest.fixture(scope='module')
def blink(results) -> dict[str, Any]:
    """Give what guest_blink.py found."""
    return json.loads((results / 'blink.json').read_text())


def along(name: str, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return for places on a light's path their frame and how far off it they are, px."""
    frames = np.arange(0.0, BLINK_FRAMES, 0.02)
    light = blinking_lights()[name]
    path = np.array([light.spot(frame / FRAME_RATE)[:2] for frame in frames])
    away = np.linalg.norm(places[:, None] - path, axis=2)
    nearest = away.argmin(axis=1)
    return frames[nearest], away[np.arange(len(places)), nearest]


@pytest.mark.parametrize('name', LIGHTS)
def test_each_light_is_on_its_path(blink, name):
    places = np.array(blink['places'][name])
    assert len(places) >= blink['count']
    assert (np.diff(places[:, 0]) > 0).all()
    _, off = along(name, places[:, 1:])
    assert (off < TOLERANCE).mean() >= RIGHT
    assert np.median(off) < 0.05


@pytest.mark.parametrize('name', LIGHTS)
def test_it_goes_along_its_path_by_the_stamps(blink, name):
    places = np.array(blink['places'][name])
    frames, off = along(name, places[:, 1:])
    right = off < TOLERANCE
    seconds = np.diff(places[right, 0]) / 1e9
    ahead = (np.diff(frames[right]) - seconds * FRAME_RATE + 0.5 * BLINK_FRAMES) % BLINK_FRAMES
    near = seconds < NEAR
    assert near.sum() >= 3
    # A frame that came twice or never is one ahead or behind.
    assert np.median(np.abs(ahead[near] - 0.5 * BLINK_FRAMES)) <= 1.5


def test_the_node_ends_without_a_trace(blink, results):
    code, _ = blink['exits']['pipeline']
    log = (results / 'blink.log').read_text()
    assert code == 0, log
    assert 'Traceback' not in log
