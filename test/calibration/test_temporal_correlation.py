"""Frames that hang together in time are found with the right number, others are let pass."""

from __future__ import annotations

from collections.abc import Iterator

from blob_tracker.calibration.temporal_correlation import Succession, TemporalCorrelation
from blob_tracker.simulation import FlatField, Scene, Sensor
from blob_tracker.types import Pixels, SensorNoise
import numpy as np
import pytest

FIELD = FlatField(
    Sensor(SensorNoise(3.6, 3.0, 20.0), bits=12, prnu=0.02, dsnu=0.5), width=160, height=120,
)
SETTLED = 8  # frames after which a recursion of 0.3 has forgotten its start to 1e-4


def filtered(frames: Iterator[Pixels], kept: float) -> Iterator[Pixels]:
    """Yield what a temporal noise reduction makes of frames, once it has settled."""
    out: np.ndarray | None = None
    for index, image in enumerate(frames):
        out = image.astype(float) if out is None else kept * out + (1.0 - kept) * image
        if index >= SETTLED:
            yield np.rint(out).astype(image.dtype)


def flat(
    signal: float, count: int, random: np.random.Generator, drift: float = 0.0
) -> Iterator[Pixels]:
    """Yield flat frames under a lamp that drifts by a part of its light from one to the next."""
    for index in range(count + SETTLED):
        yield FIELD.frame(signal * (1.0 + drift * index), random)


def found_in(kept: float, seed: int, drift: float = 0.0) -> TemporalCorrelation:
    """Return what six frames at each of three lights tell."""
    random = np.random.default_rng(seed)
    succession = Succession()
    for signal in (0.0, 400.0, 2000.0):
        for image in filtered(flat(signal, 6, random, drift), kept):
            succession.add(image, signal)
    found = succession.found()
    assert found is not None and found.triples == 6
    return found


@pytest.mark.parametrize('kept', [0.1, 0.2, 0.3])
def test_a_recursion_is_found_with_its_share(kept: float) -> None:
    """And refused, with what is wrong and what to do."""
    found = found_in(kept, seed=1)
    assert abs(found.value - kept) < 4.0 * found.sigma < 0.04
    assert 'correlation 0.' in found.fault and 'noise reduction' in found.fault


@pytest.mark.parametrize('drift', [0.0, 0.002, -0.002])
def test_white_noise_is_none_under_a_lamp_that_drifts(drift: float) -> None:
    """The mean square of 24 draws over their sigmas is 1, within three sigma of such a mean."""
    draws = [found_in(0.0, seed, drift) for seed in range(24)]
    squares = [(each.value / each.sigma) ** 2 for each in draws]
    assert abs(np.mean(squares) - 1.0) < 3.0 * np.sqrt(2.0 / 24)
    assert not any(each.fault for each in draws)


def test_a_scene_in_which_something_moves() -> None:
    """A still one with flicker is clean; the same behind a noise reduction is not."""
    scene = Scene(width=320, height=240, background=90.0, sensor=Sensor(SensorNoise(8.0, 1.2)))
    random = np.random.default_rng(2)
    box = random.uniform(20.0, 120.0, (60, 60))

    def frames() -> Iterator[Pixels]:
        for index in range(12 + SETTLED):
            image = scene.frame(index).astype(float)
            # 60 x 60 px of texture go by at 3 px a frame: 5 % of the picture.
            image[100:160, 20 + 3 * index:80 + 3 * index] = box
            yield np.rint(image * (1.0 + 0.01 * (index % 2))).astype(np.uint8)

    for kept in (0.0, 0.2):
        succession = Succession()
        for image in filtered(frames(), kept):
            succession.add(image)
        found = succession.found()
        assert found is not None
        assert bool(found.fault) == (kept > 0.0)
        # The tiles in motion move the median by less than the tolerance.
        assert found.value == pytest.approx(kept, abs=0.03)


def test_frames_that_come_twice_are_counted() -> None:
    """24 frames made 30: each fourth one twice. Clipped frames and constant dark ones are none."""
    random = np.random.default_rng(3)
    succession = Succession()
    for index in range(12):
        image = FIELD.frame(400.0, random)
        succession.add(image)
        if index % 4 == 3:
            succession.add(image)
    found = succession.found()
    assert found is not None and found.repeated == 3
    assert 'repeats frames' in found.fault
    quiet = FlatField(
        Sensor(SensorNoise(3.6, 0.05, 16.0), bits=12, dsnu=2.0), width=160, height=120
    )
    succession = Succession()
    for signal in (0.0, 400.0, 9000.0):
        for _ in range(3):
            succession.add(quiet.frame(signal, random), signal)
    found = succession.found()
    assert found is not None and found.repeated == 0 and not found.fault


def test_two_frames_of_a_light_tell_nothing() -> None:
    """Nor do frames of which no three are of one light."""
    random = np.random.default_rng(4)
    succession = Succession()
    for signal in (0.0, 400.0, 2000.0):
        for _ in range(2):
            succession.add(FIELD.frame(signal, random))
    assert succession.found() is None
