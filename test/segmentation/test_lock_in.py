"""A free-running light is found at any frequency and phase; the SNR grows with sqrt(k)."""

from __future__ import annotations

from typing import Any

from blob_tracker.location import locate
from blob_tracker.segmentation import Segmenter
from blob_tracker.segmentation.lock_in import lock_in_weights, LockIn
from blob_tracker.simulation import Light, periodic, Scene
from blob_tracker.types import Frame, SensorNoise, Window
import numpy as np
import pytest

RATE = 60.0
X, Y = 71.3, 52.6


def scene(frequency: float, duty: float = 0.5, **options: Any) -> Scene:
    """Return a light of 40 DN and 2 px that flashes at a part `frequency` of the frame rate."""
    amplitude = float(options.pop('amplitude', 40.0))
    phase = float(options.pop('phase', 0.1))
    light = Light(X, Y, 2.0, amplitude, periodic(frequency * RATE, duty, phase))
    return Scene(light, width=160, height=120, rate=RATE, texture=0.0, **options)


def mode(frequency: float, frames: int, duty: float = 0.5) -> LockIn:
    """Return the mode for it."""
    return LockIn(
        max_pair_interval=0.1, frequency=frequency * RATE, duty=duty, frames=frames
    )


def windows(lights: Scene, flash: LockIn, indices: range) -> list[Window]:
    """Return the windows of these frames."""
    segmenter = Segmenter(flash=flash)
    found = [
        segmenter.update(Frame(lights.frame(k), lights.stamp_ns(k), 255)) for k in indices
    ]
    return [window for window in found if window is not None]


@pytest.mark.parametrize('frequency', [0.1, 0.173, 0.25, 0.31, 0.4, 0.45])
@pytest.mark.parametrize('exposure', [0.2, 0.9])
def test_every_block_shows_the_light(frequency: float, exposure: float) -> None:
    """Any frequency from 0.1 to 0.45 of the frame rate, the exposure straddling edges or not."""
    lights = scene(frequency, exposure=exposure)
    found = windows(lights, mode(frequency, 20), range(60))
    assert len(found) == 3
    for window in found:
        # Sums of 9 frames keep the gain; their read noise is three times that of one.
        location = locate(window, noise=SensorNoise(gain=40.0, read_noise=3 * 0.76))
        assert np.hypot(location.x - X, location.y - Y) < 0.1
        assert window.lit.dtype == np.uint16 and window.saturation == 65535


@pytest.mark.parametrize('duty', [0.2, 0.8])
def test_short_and_long_flashes_are_found(duty: float) -> None:
    """The window's lit frames are brighter than its unlit ones for either duty."""
    found = windows(scene(0.23, duty), mode(0.23, 20, duty), range(40))
    assert len(found) == 2
    for window in found:
        assert (window.lit.astype(int) - window.unlit).max() > 40


def snr(frames: int) -> float:
    """Return the mean SNR of the light's amplitude over blocks of so many frames."""
    lights = scene(0.2371, amplitude=30.0)
    segmenter = Segmenter(flash=mode(0.2371, frames))
    found = []
    for index in range(16 * frames):
        if segmenter.update(Frame(lights.frame(index), lights.stamp_ns(index), 255)):
            found.append(segmenter.detections.candidates[0])
    assert len(found) == 16
    return float(np.mean([each.amplitude / each.noise for each in found]))


def test_snr_grows_with_the_root_of_the_frames() -> None:
    """From 16 to 64 frames it doubles."""
    # Each SNR is known to 3 % (16 blocks of an SNR near 30, and the phases of the edges).
    assert snr(64) / snr(16) == pytest.approx(2.0, rel=0.1)


def test_a_light_below_the_noise_of_one_frame_is_found() -> None:
    """Peak 1.8 DN over 1.25 DN of noise: 64 frames see it, 8 do by chance."""
    lights = scene(0.2371, amplitude=1.8)
    assert len(windows(lights, mode(0.2371, 8), range(64))) <= 1  # of 8 blocks
    assert len(windows(lights, mode(0.2371, 64), range(64))) == 1


def test_dropped_frames_cost_nothing_but_themselves() -> None:
    """The stamps give the phase."""
    lights = scene(0.31)
    indices = [k for k in range(60) if k % 7]
    segmenter = Segmenter(flash=mode(0.31, 17))
    found = [
        segmenter.update(Frame(lights.frame(k), lights.stamp_ns(k), 255)) for k in indices
    ]
    assert sum(window is not None for window in found) == 3


@pytest.mark.parametrize('lights', [
    scene(0.25, amplitude=0.0),
    scene(0.0, 1.0),  # always on
    scene(0.4),  # another frequency
], ids=['never on', 'always on', 'other frequency'])
def test_what_does_not_flash_at_the_frequency_is_none(lights: Scene) -> None:
    """0.4 is two bins of a block of 40 frames and more away from 0.25."""
    segmenter = Segmenter(flash=mode(0.25, 40))
    for index in range(40):
        frame = Frame(lights.frame(index), lights.stamp_ns(index), 255)
        assert segmenter.update(frame) is None
    assert 'nothing lit up' in segmenter.reason


def test_a_frequency_that_the_frames_cannot_show_is_named() -> None:
    """Beyond 0.45 of the frame rate it would be aliased."""
    lights = scene(0.6)
    segmenter = Segmenter(flash=mode(0.6, 8))
    for index in range(8):
        segmenter.update(Frame(lights.frame(index), lights.stamp_ns(index), 255))
    assert 'said to flash at 36 Hz; 60.0 frames a second show 6.0 to 27.0 Hz' in segmenter.reason


def test_weights_take_no_share_of_what_is_steady() -> None:
    """They are those of least squares: 1, cos and sin give (0, 0), (1, 0) and (0, 1)."""
    phases = np.array([0.0, 0.7, 1.9, 3.3, 4.1, 6.0])
    weights = lock_in_weights(phases)
    design = np.column_stack([np.ones(6), np.cos(phases), np.sin(phases)])
    np.testing.assert_allclose(weights @ design, [[0, 1, 0], [0, 0, 1]], atol=1e-12)


@pytest.mark.parametrize('options', [{'frames': 3}, {'duty': 1.0}, {'frequency': 0.0}])
def test_impossible_options_are_refused(options: dict[str, Any]) -> None:
    """With a sentence."""
    with pytest.raises(ValueError, match='must'):
        LockIn(**{
            'max_pair_interval': 0.1, 'frequency': 15.0, 'duty': 0.5, 'frames': 16, **options,
        })


@pytest.mark.parametrize('speed', [0.25, 0.5, 2.0, 10.0])
def test_a_light_that_moves_is_refused(speed: float) -> None:
    """Px a frame: no window is more than 1 px off its path, and the reason says why."""
    random = np.random.default_rng(6)
    segmenter = Segmenter(flash=LockIn(frequency=10.0, frames=16))
    columns, rows = np.arange(320), np.arange(60)
    for index in range(96):
        x = 60.0 + (speed * index) % 200.0
        on = (index / RATE * 10.0) % 1.0 < 0.5
        image = 20.0 + random.standard_normal((60, 320))
        image += 100.0 * on * np.outer(
            np.exp(-0.5 * ((rows - 30.2) / 1.5) ** 2), np.exp(-0.5 * ((columns - x) / 1.5) ** 2)
        )
        window = segmenter.update(
            Frame(np.rint(image.clip(0, 255)).astype(np.uint8), round(1e9 * index / RATE), 255)
        )
        assert window is None
        if index % 16 == 15:
            assert 'the mode periodic follows' in segmenter.reason or 'rise' in segmenter.reason
