"""The scenes are what their names say: SNR, electrons, clipping, texture, and the bound."""

from __future__ import annotations

from benchmarks.accuracy import NAMED, sweeps, target_scenes
from benchmarks.scenes import amplitude, sample, Scene
from benchmarks.windows import clipped
from blob_tracker.location.limits import cramer_rao_bound
from blob_tracker.types import SensorNoise
import numpy as np
import pytest

MIDDLE = np.zeros((1, 2))  # the one place in the middle of the middle pixel


@pytest.mark.parametrize('snr', [3.0, 50.0, 200.0])
def test_snr_is_amplitude_over_the_noise_at_the_peak(snr: float) -> None:
    """Solve A = SNR sqrt((A + b) / gain + read_noise^2 + 1/12)."""
    scene = Scene(9, 1.5, snr, SensorNoise(8.0, 0.7), background=11.0)
    level = amplitude(scene)
    noise = np.sqrt((level + 11.0) / 8.0 + 0.7**2 + 1.0 / 12.0)
    assert level / noise == pytest.approx(snr, rel=1e-12)


def test_snr_of_the_pixels_themselves() -> None:
    """Find the SNR in the middle pixel of exposed windows of a pulse as wide as many pixels."""
    seen = sample(Scene(5, 8.0, 30.0), 20_000, 1, MIDDLE).windows.lit[:, 2, 2].astype(float)
    # 20 DN of background are known; a standard deviation from 20,000 pixels is good to 0.5 %.
    assert (seen.mean() - 20.0) / seen.std() == pytest.approx(30.0, rel=0.02)


@pytest.mark.parametrize(('name', 'electrons'), [*zip(NAMED, (1000, 5000, 20000))])
def test_named_scenes_hold_their_electrons(name: str, electrons: int) -> None:
    """Hold the N of the name in A 2 pi sigma^2 gain."""
    scene = sweeps()['scene'][name]
    held = amplitude(scene) * 2.0 * np.pi * scene.sigma**2 * scene.noise.gain
    assert held == pytest.approx(electrons, rel=1e-9)
    assert f'{scene.window}x{scene.window}' in name


def test_target_scenes_are_those_of_the_target() -> None:
    """Cover windows 7 to 15 and SNR 10 to 200, three sigma to either side."""
    scenes = target_scenes().values()
    assert {scene.window for scene in scenes} == {7, 9, 11, 15}
    assert {min(s.snr for s in scenes), max(s.snr for s in scenes)} == {10, 200}
    assert all(scene.sigma == pytest.approx(scene.window / 6) for scene in scenes)


def test_overexposure_clips_the_peak() -> None:
    """Set full scale to the amplitude over the overexposure."""
    scene = Scene(15, 2.0, 100.0, overexposure=4.0)
    windows = sample(scene, 50, 2, MIDDLE).windows
    assert windows.saturation == round(amplitude(scene) / 4.0)
    assert windows.lit.max() == windows.saturation
    # exp(-r^2 / 2 sigma^2) > 1/4 within r = 2 sqrt(2 ln 4) px: pi r^2 = 34.8 pixels.
    assert clipped(windows).sum(axis=(1, 2)).mean() == pytest.approx(34.8, rel=0.15)


def test_texture_is_relative_to_the_ambient_light() -> None:
    """Show the texture in the unlit windows, and the same in the lit ones."""
    scene = Scene(11, 1.5, 50.0, background=100.0, texture=0.3)
    windows = sample(scene, 400, 3, MIDDLE).windows
    assert windows.unlit is not None
    unlit = windows.unlit.astype(float)
    # Its own noise, sqrt(100 / 20 + ...) = 2.3 DN, adds 0.3 % to the 30 DN of texture.
    assert unlit.std() == pytest.approx(30.0, rel=0.03)
    corner = windows.lit[:, 0, 0].astype(float)
    assert np.corrcoef(corner, unlit[:, 0, 0])[0, 1] > 0.95


def test_bound_of_a_sample_is_the_mean_over_its_places() -> None:
    """Agree with the package's bound at the same places."""
    scene = Scene(7, 1.1, 40.0)
    seen = sample(scene, 30, 4)
    bounds = [
        np.trace(
            cramer_rao_bound(
                (7, 7), x=x, y=y, sigma=1.1, amplitude=amplitude(scene), background=20.0,
                noise=scene.noise,
            )
        ) / 2
        for x, y in zip(seen.x, seen.y)
    ]
    assert seen.bound == pytest.approx(np.sqrt(np.mean(bounds)), rel=1e-5)
    assert np.abs(np.stack([seen.x, seen.y]) - 3.0).max() <= 0.5


def test_samples_are_the_same_every_time() -> None:
    """Give every contender the same windows, run by run."""
    scene = Scene(7, 1.1, 40.0, texture=0.1)
    first, second = (sample(scene, 20, 5).windows for _ in range(2))
    np.testing.assert_array_equal(first.lit, second.lit)
    assert first.unlit is not None
    np.testing.assert_array_equal(first.unlit, second.unlit)
