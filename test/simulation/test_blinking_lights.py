"""Lights that blink and move: each frame has what the truth tells of, streak included."""

from __future__ import annotations

from dataclasses import replace

from blob_tracker.blinking import code, Pattern, wave
from blob_tracker.blinking.patterns import look
from blob_tracker.simulation import (
    blinking_lights, in_step, Light, periodic, Scene, Sensor, truth_of, waveforms_of,
)
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

RATE = 60.0
QUIET = Sensor(SensorNoise(gain=np.inf, read_noise=0.0), bits=16)
CODES = {'port': '1101000', 'starboard': '1110100'}
AMPLITUDE = 20_000.0


def centroid(image: np.ndarray) -> tuple[float, float]:
    """Return the centre of gravity, px."""
    rows, columns = np.indices(image.shape)
    total = image.sum(dtype=float)
    return (image * columns).sum() / total, (image * rows).sum() / total


@pytest.mark.parametrize('row_time', [0.0, 1e-4])
def test_the_centre_of_a_streak_is_where_the_light_was_at_its_instant(row_time: float) -> None:
    """A wave of 13.7 Hz at up to 6 px a frame, at all shares of the exposure."""
    scene, lights = blinking_lights(
        waveforms_of('periodic', frequency=13.7), width=160, height=120, rate=RATE,
        amplitude=AMPLITUDE, background=0.0, texture=0.0, period=2.0,
        sensor=replace(QUIET, row_time=row_time),
    )
    light, shares = lights[''], []
    for index in range(60):
        truth = truth_of(light, scene.shot(index))
        if truth.amplitude == 0.0:
            assert not row_time == 0.0 or scene.frame(index).max() == 0
            continue
        shares.append(truth.amplitude / AMPLITUDE)
        if shares[-1] > 0.1:
            # Of a part of an exposure, 0.03 of a frame, it may be lit half; and the path bends by
            # a t^2 / 24: 0.03 px. Rows that are lit in part draw the centre of a rolling shutter.
            assert centroid(scene.frame(index)) == pytest.approx(
                (truth.x, truth.y), abs=0.05 if row_time == 0.0 else 0.5)
    assert min(shares) < 0.5 and shares.count(1.0) > 10


@pytest.mark.parametrize('pattern, waveforms', [
    (wave('', 13.7, 0.3), waveforms_of('periodic', frequency=13.7, duty=0.3)),
    (code('port', CODES['port'], 40.0), waveforms_of('coded', codes=CODES, bits_per_second=40.0)),
])
def test_share_and_instant_are_those_that_the_tracker_tabulates(
    pattern: Pattern, waveforms: dict
) -> None:
    """Whatever its phase, a frame shows what `blinking.patterns.look` says of one."""
    exposure = 0.5 / RATE
    share, tau = look(pattern, 2000, exposure)
    scene, lights = blinking_lights(waveforms, rate=RATE)
    light = lights[pattern.name]
    for index in range(40):
        truth = truth_of(light, scene.shot(index))
        # A thousandth of the exposure in each: its slices.
        off = np.abs(share - truth.amplitude / light.amplitude)
        off += np.where(share > 0.01, np.abs(tau - truth.tau) / exposure, 0.0)
        assert off.min() < 0.005


def test_lights_in_step_change_between_the_exposures() -> None:
    """On for the whole of one or for none of it, bit by bit."""
    scene, lights = blinking_lights(
        waveforms_of('coded', rate=RATE, codes=CODES, frames_per_bit=2), rate=RATE
    )
    for name, bits in CODES.items():
        seen = [truth_of(lights[name], scene.shot(k)).lit for k in range(2 * len(bits))]
        assert seen == [bit == '1' for bit in bits for _ in range(2)]
        taus = [truth_of(lights[name], scene.shot(k)).tau for k in range(14)]
        assert taus == pytest.approx(np.zeros(14), abs=1e-12)


def test_three_lights_keep_apart() -> None:
    """No nearer than several times their width."""
    _, lights = blinking_lights({name: in_step(RATE) for name in 'abc'})
    places = np.array([
        [each.spot(time)[:2] for each in lights.values()] for time in np.arange(0.0, 9.0, 0.01)
    ])
    apart = np.linalg.norm(places[:, [0, 1, 2]] - places[:, [1, 2, 0]], axis=2)
    assert apart.min() > 36.0


def test_clocks_may_be_off_and_a_steady_light_is_always_on() -> None:
    """By the part that is asked for."""
    times = np.arange(0.0, 1.0, 1e-3)
    fast = waveforms_of('periodic', frequency=10.0, clock_error=0.01)['']
    np.testing.assert_array_equal(fast(times), periodic(10.1, 0.5, 0.13)(times))
    assert waveforms_of('steady')[''](times).all()
    in_pairs = waveforms_of('alternate', rate=RATE, lights=('a', 'b'))
    assert tuple(in_pairs) == ('a', 'b')
    assert in_pairs['b'](np.arange(4) / RATE).tolist() == [1.0, 0.0, 1.0, 0.0]
    named = waveforms_of('periodic', frequencies={'left': 6.0, 'right': 10.0})
    assert list(named) == ['left', 'right']
    both = waveforms_of('coded', codes=CODES, frequencies={'left': 6.0})
    assert list(both) == ['left', 'port', 'starboard']


def test_without_streaks_a_light_stands_still_while_it_is_exposed() -> None:
    """As the thesis has it: its place is that of the middle, and so is its instant."""
    light = Light(80.0, 60.0, 2.0, AMPLITUDE, periodic(13.7, 0.3), 50.0, 40.0, period=2.0)
    scene = Scene(light, width=160, height=120, background=0.0, texture=0.0, sensor=QUIET)
    for index in range(30):
        truth = scene.truth(index)
        assert truth.tau == 0.0
        assert (truth.x, truth.y) == pytest.approx(light.spot(index / RATE)[:2], abs=1e-9)
