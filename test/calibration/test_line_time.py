"""The line time from simulated bands, against the one that was put in; and what tells of none."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from blob_tracker.calibration.line_time import FEWEST, LineTimeError, measure_line_time
from blob_tracker.types import Pixels
import numpy as np
import pytest

HEIGHT, WIDTH = 480, 16
LINE = 30e-6  # s
RATE = 29.97  # Hz
Timed = tuple[float | None, Pixels]


def frames(
    line_time: float, *, frequency: float = 100.0, rate: float = RATE, count: int = 20,
    exposure: float = 2e-3, depth: float = 0.2, half: float = 0.0, duty: float = 0.0,
    stamps: bool = True, seed: int = 1,
) -> Iterator[Timed]:
    """
    Yield frames of a wall in the light of a lamp.

    `half` is how unlike its half-periods are, `duty` that of a PWM. The stamps jitter by 0.2 ms.
    """
    random = np.random.default_rng(seed)
    wall = 80.0 + 10.0 * np.sin(np.arange(HEIGHT)[:, None] / 17.0)
    parts = exposure * ((np.arange(40) + 0.5) / 40 - 0.5)
    for index in range(count):
        time = index / rate
        seen = time + line_time * np.arange(HEIGHT)[:, None] + parts
        if duty:
            light = (frequency * seen % 1.0 < duty) / duty
        else:
            light = 1.0 + depth * np.cos(2 * np.pi * frequency * seen)
            light = light + half * np.cos(np.pi * frequency * seen)
        mean = wall * light.mean(axis=1, keepdims=True)
        pixels = mean + random.normal(0.0, 2.0, (HEIGHT, WIDTH))
        stamp = time + random.normal(0.0, 2e-4) if stamps else None
        yield stamp, np.clip(np.rint(pixels), 0, 255).astype(np.uint8)


@pytest.mark.parametrize('frequency', [100.0, None])
@pytest.mark.parametrize('line_time', [LINE, -LINE])
def test_a_lamp_on_the_mains_tells_time_and_direction(
    line_time: float, frequency: float | None
) -> None:
    """Within 4 of the stated sigma, which is a part in a thousand or less."""
    found = measure_line_time(frames(line_time), frequency)
    assert found.frequency == 100.0 and found.directed
    assert found.bands == pytest.approx(100.0 * LINE * HEIGHT, rel=0.01)
    assert 0.0 < found.sigma < 1e-3 * LINE
    assert abs(found.line_time - line_time) < 4.0 * found.sigma


def test_the_sigma_is_true() -> None:
    """Mean square of 20 errors over their sigmas: 1 +- 0.32, and within four of these."""
    errors = []
    for seed in range(20):
        found = measure_line_time(frames(LINE, seed=seed, count=12), 100.0)
        errors.append((found.line_time - LINE) / found.sigma)
    assert 0.3 < np.mean(np.square(errors)) < 2.3


def test_a_pwm_of_known_frequency_without_stamps() -> None:
    """Its direction is not told."""
    found = measure_line_time(
        frames(LINE, frequency=1000.0, exposure=1e-4, duty=0.3, stamps=False, count=FEWEST), 1000.0
    )
    assert not found.directed
    assert found.line_time == pytest.approx(LINE, rel=1e-3)


@pytest.mark.parametrize(('given', 'options', 'words'), [
    (100.0, {'line_time': 0.0}, 'no bands'),
    (100.0, {'line_time': LINE, 'exposure': 0.01}, 'no bands'),
    (100.0, {'line_time': LINE, 'rate': 25.0}, 'no bands'),  # they stand still
    (100.0, {'line_time': 1e-5}, 'there must be one or more'),
    (None, {'line_time': LINE, 'stamps': False}, 'ambiguous'),
    (None, {'line_time': LINE, 'rate': 20.1}, 'ambiguous'),  # 120 Hz would move them alike
    (120.0, {'line_time': LINE}, 'do not move'),
    (100.0, {'line_time': 2 * LINE, 'half': 0.2}, 'bands 333.4 and 166.7 lines apart'),
    (100.0, {'line_time': LINE, 'count': FEWEST - 1}, '3 frames'),
])
def test_what_does_not_tell_is_refused(
    given: float | None, options: dict[str, Any], words: str
) -> None:
    """With what would help."""
    with pytest.raises(LineTimeError, match=words):
        measure_line_time(frames(**options), given)
