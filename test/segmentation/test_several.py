"""Lights that look alike are all found, steady or in step with the camera; nothing else is."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.flash_text import numbered_lights
from blob_tracker.segmentation import flash_by_name, Segmenter
from blob_tracker.segmentation.several import AlternateLights, SteadyLights
from blob_tracker.simulation import blinking_lights, Light, Scene, truth_of, waveforms_of
from blob_tracker.simulation.waveforms import periodic
from blob_tracker.types import Frame
import numpy as np
import pytest

RATE = 30.0
LIGHTS = 4


def play(scene: Scene, mode: str, count: int) -> list[dict[str, tuple[float, float]]]:
    """Return the middles of the windows of each frame, by the names of the lights."""
    segmenter = Segmenter(flash=flash_by_name(mode, lights=LIGHTS))
    found = []
    for index in range(count):
        frame = Frame(scene.frame(index), 1 + round(1e9 * index / RATE), 255)
        found.append({
            name: (window.x0 + 0.5 * window.lit.shape[1], window.y0 + 0.5 * window.lit.shape[0])
            for name, window in segmenter.sightings(frame)
        })
    return found


@pytest.mark.parametrize('mode, first, step', [('steady', 0, 1), ('alternate', 6, 2)])
def test_all_lights_keep_their_numbers(mode: str, first: int, step: int) -> None:
    """Each window is about the light whose number it had in the first frame."""
    scene, lights = blinking_lights(
        waveforms_of(mode, rate=RATE, lights=numbered_lights(LIGHTS)),
        width=320, height=240, rate=RATE,
    )
    found = play(scene, mode, 24)
    assert [index for index, each in enumerate(found) if each] == list(range(first, 24, step))
    owners: dict[str, str] = {}
    for index in range(first, 24, step):
        assert tuple(found[index]) == numbered_lights(LIGHTS)
        for name, place in found[index].items():
            away = {
                light: np.hypot(truth.x - place[0], truth.y - place[1])
                for light, truth in (
                    (light, truth_of(each, scene.shot(index))) for light, each in lights.items())
            }
            nearest = min(away, key=away.__getitem__)
            assert away[nearest] < 3.0
            assert owners.setdefault(name, nearest) == nearest
    assert len(set(owners.values())) == LIGHTS


def test_a_lamp_beside_lights_in_step_is_left_out() -> None:
    """It flickers at a fifth of the frame rate: never twice in a row two frames apart."""
    scene, lights = blinking_lights(
        waveforms_of('alternate', rate=RATE, lights=('a', 'b')), width=320, height=240, rate=RATE)
    lamp = Light(30.0, 200.0, 2.0, 150.0, periodic(RATE / 5.0, 0.5, 0.13))
    found = play(replace(scene, elements=(*scene.elements, lamp)), 'alternate', 40)
    assert all(len(each) == 2 for each in found[6::2])
    assert not any(found[1::2])


def test_what_cannot_be_is_said() -> None:
    """Several lights without names are those of two modes, and no frame is laid over another."""
    assert isinstance(flash_by_name('steady', lights=2), SteadyLights)
    assert isinstance(flash_by_name('alternate', lights=2), AlternateLights)
    with pytest.raises(ValueError, match='lights is 3; it must be 1 with mode .coded.'):
        flash_by_name('coded', lights=3)
    with pytest.raises(ValueError, match='with several lights .flash.lights. it must be .none.'):
        flash_by_name('alternate', lights=2, registration='affine')


def test_a_scene_without_lights_says_why() -> None:
    """As with one light."""
    scene, _ = blinking_lights({}, width=160, height=120)
    segmenter = Segmenter(flash=SteadyLights(lights=3))
    assert segmenter.sightings(Frame(scene.frame(0), 1, 255)) == []
    assert segmenter.reason
