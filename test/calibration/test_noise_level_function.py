"""Noise from an ordinary scene: the truth within its sigma, still or moving, or a reason."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from blob_tracker import CameraModel, Frame, Pipeline
from blob_tracker.calibration.noise_level_function import NoiseLevelFunction
from blob_tracker.location import Locator
from blob_tracker.location.noise import pixel_variance
from blob_tracker.pipeline import window_to_bearing
from blob_tracker.simulation import (
    AmbientLight, Drifting, expose, in_step, Light, PassingObject, Scene, Sensor, sinusoid,
)
from blob_tracker.types import Bearing, SensorNoise
import cv2
import numpy as np
import pytest
from support.gamma import seen, still_scene

DRAWS = 100
BOUND = 1.96 * 2.0 / np.sqrt(DRAWS)  # 95 % of means of chi-square with 2 degrees of freedom
NOISE = SensorNoise(gain=8.0, read_noise=1.2)
SCENE = Scene(width=480, height=360, background=90.0, texture=15.0, sensor=Sensor(NOISE))
SECOND = 10**9  # ns


def measured(scene: Scene, pairs: int = 20, gap: int = 2) -> NoiseLevelFunction:
    """Return what pairs of frames, a second apart, tell."""
    found = NoiseLevelFunction(memory=1e6)
    for index in range(pairs):
        first, second = scene.frame(60 * index), scene.frame(60 * index + gap)
        found.add(first, second, scene.sensor.saturation, index * SECOND)
    return found


def pull(found: NoiseLevelFunction, noise: SensorNoise) -> float:
    """Return chi-square of the line: slope and foot under their covariance."""
    line = found.line()
    assert line is not None, found.reason
    error = [line.slope - 1.0 / noise.gain, line.foot - noise.read_noise**2 - 1.0 / 12.0]
    return float(error @ np.linalg.solve(line.covariance, error))


def test_the_truth_is_within_the_sigmas() -> None:
    """Of 100 sensors before a still scene that goes from dark to clipped."""
    random = np.random.default_rng(17)
    squares = []
    for _ in range(DRAWS):
        noise = SensorNoise(
            gain=float(np.exp(random.uniform(np.log(0.5), np.log(200.0)))),
            read_noise=float(np.exp(random.uniform(np.log(0.3), np.log(5.0)))),
        )
        saturation = int(random.choice([255, 1023, 4095, 65535]))
        prnu = 1.0 + random.uniform(0.0, 0.02) * random.standard_normal((240, 320))
        patches = cv2.resize(random.uniform(0.0, 1.1, (6, 8)) ** 2, (320, 240))
        mean = saturation * patches * prnu
        found = NoiseLevelFunction(memory=1e6, tiles=None)
        for index in range(8):
            one, two = (expose(mean, noise, random, saturation=saturation) for _ in range(2))
            found.add(one, two, saturation, index)
        if found.line() is None:
            # Shot noise of full scale that is less than the read noise is no contrast.
            assert 'not enough contrast' in found.reason
            assert saturation / noise.gain < noise.read_noise**2
        else:
            squares.append(pull(found, noise))
    assert len(squares) >= 0.95 * DRAWS
    assert abs(np.mean(squares) - 2.0) < BOUND


@pytest.mark.parametrize('black_level', [10.0, 64.0])
def test_a_pedestal_is_no_obstacle(black_level: float) -> None:
    """Read noise and black level are not told apart, and the variance is right at every level."""
    noise = replace(NOISE, black_level=black_level)
    scene = replace(SCENE, background=SCENE.background + black_level, sensor=Sensor(noise))
    line = measured(scene, pairs=40).line()
    assert line is not None
    assert (line.noise.read_noise == 0.0) == (black_level > NOISE.gain * NOISE.read_noise**2)
    levels = black_level + np.array([60.0, 90.0, 120.0])
    np.testing.assert_allclose(
        pixel_variance(levels, line.noise), pixel_variance(levels, noise), rtol=0.015
    )


def test_a_still_scene_in_few_tiles() -> None:
    """Twenty seconds tell both to some per cent."""
    line = measured(SCENE).line()
    assert line is not None
    sigma = np.sqrt(np.diag(line.noise_covariance))
    assert sigma[0] < 0.02 * NOISE.gain and sigma[1] < 0.06 * NOISE.read_noise
    assert abs(line.gain - NOISE.gain) < 3.0 * sigma[0]
    assert abs(line.read_noise - NOISE.read_noise) < 3.0 * sigma[1]


@pytest.mark.parametrize('speed', [0.02, 0.05, 0.1])
def test_slow_motion_does_not_bias(speed: float) -> None:
    """Up to 0.2 px between the frames of a pair are taken out with the gradient."""
    found = measured(replace(SCENE, camera=Drifting(speed, radius=60.0)), pairs=40)
    line = found.line()
    assert line is not None
    # Unmodelled, 0.1 px a frame adds (0.2 px x 5 DN/px)^2 / 2 to a variance of 12 DN^2: 4 %.
    for level in (60.0, 120.0):
        truth = level / NOISE.gain + NOISE.read_noise**2 + 1.0 / 12.0
        assert line.variance(level)[0] == pytest.approx(truth, rel=0.015)


@pytest.mark.parametrize('speed', [0.5, 2.0, 7.0, 20.0])
@pytest.mark.parametrize('texture', [2.0, 15.0])
def test_fast_motion_is_left_out(speed: float, texture: float) -> None:
    """Nothing is told, rather than the texture's variance; by chance a flat scene tells some."""
    found = measured(replace(SCENE, texture=texture, camera=Drifting(speed, radius=60.0)))
    line = found.line()
    if line is None:
        assert 'the scene moves' in found.reason or 'not enough contrast' in found.reason
    else:
        variance, sigma = line.variance(90.0)
        truth = 90.0 / NOISE.gain + NOISE.read_noise**2 + 1.0 / 12.0
        assert abs(variance - truth) < 0.02 * truth + 3.0 * sigma


def test_what_moves_in_a_still_scene_is_left_out() -> None:
    """A block that passes takes its tiles out and leaves the others."""
    passing = PassingObject(0.0, 100.0, 150.0, 150.0, 200.0, 4.0)
    assert pull(measured(replace(SCENE, elements=(passing,))), NOISE) < 9.2  # 99 %


def test_flicker_of_the_mains_is_taken_out() -> None:
    """Light that goes up and down by a tenth, on all of the scene."""
    lamps = AmbientLight(sinusoid(97.0, 0.1))
    scene = replace(SCENE, elements=(lamps,))
    changes = [float(scene.frame(60 * k + 2).mean() - scene.frame(60 * k).mean()) for k in (0, 1)]
    assert max(map(abs, changes)) > 1.0  # or the test tests nothing
    assert pull(measured(scene), NOISE) < 9.2  # 99 %


def test_one_level_tells_the_variance_there() -> None:
    """Of an even wall the sentence has level and variance."""
    random = np.random.default_rng(3)
    found = NoiseLevelFunction()
    wall = np.full((360, 480), 40.0)
    for index in range(10):
        one, two = (expose(wall, NOISE, random) for _ in range(2))
        found.add(one, two, 255, index * SECOND)
    assert found.line() is None
    # 40 / 8 + 1.44 + 1 / 12 = 6.52
    assert 'not enough contrast in the scene to separate gain and read noise' in found.reason
    assert 'the variance at 40 DN is 6.5' in found.reason


def test_noise_below_the_rounding_is_not_told() -> None:
    """With 0.1 DN of noise nothing but the rounding is seen."""
    found = measured(replace(SCENE, sensor=Sensor(SensorNoise(5000.0, 0.1))), pairs=10)
    assert found.line() is None
    assert 'rounding' in found.reason or 'plain noise' in found.reason


def test_compressed_frames_are_refused() -> None:
    """JPEG leaves no plain noise in any tile."""
    found = NoiseLevelFunction()
    for index in range(10):
        one, two = (
            cv2.imdecode(cv2.imencode('.jpg', SCENE.frame(60 * index + k))[1], 0).astype(np.uint8)
            for k in (0, 2)
        )
        found.add(one, two, 255, index * SECOND)
    assert found.line() is None
    assert 'compressed' in found.reason


def test_it_forgets_by_the_stamps() -> None:
    """After the gain changed the new one is told within a few times the memory."""
    found = NoiseLevelFunction(memory=10.0)
    for index in range(60):
        scene = SCENE if index < 20 else replace(SCENE, sensor=Sensor(SensorNoise(2.0, 2.0)))
        found.add(scene.frame(60 * index), scene.frame(60 * index + 2), 255, index * SECOND)
    line = found.line()
    assert line is not None
    assert line.gain == pytest.approx(2.0, rel=0.08)  # exp(-4) of the old, and 2 sigma


def test_another_saturation_forgets_nothing() -> None:
    """The bins are others; the line through all pairs is the same to their width."""
    plain = measured(SCENE, pairs=10)
    raised = NoiseLevelFunction(memory=1e6)
    for index in range(10):
        first, second = SCENE.frame(60 * index), SCENE.frame(60 * index + 2)
        raised.add(first, second, 255 if index < 9 else 1023, index * SECOND)
    one, other = plain.line(), raised.line()
    assert one is not None and other is not None
    # Without nine of ten pairs the sigma would be three times as large.
    np.testing.assert_allclose(
        np.sqrt(np.diag(other.covariance)), np.sqrt(np.diag(one.covariance)), rtol=0.2
    )
    assert other.gain == pytest.approx(one.gain, abs=np.sqrt(one.noise_covariance[0, 0]))


def test_stamps_that_jump_back_begin_afresh() -> None:
    """A bag that is played again gives the same numbers again."""
    once = measured(SCENE, pairs=10).line()
    twice = NoiseLevelFunction(memory=1e6)
    scenes = (replace(SCENE, sensor=Sensor(SensorNoise(2.0, 2.0))), SCENE)
    for scene in scenes:
        for index in range(10):
            first, second = scene.frame(60 * index), scene.frame(60 * index + 2)
            twice.add(first, second, 255, index * SECOND)
    line = twice.line()
    assert once is not None and line is not None
    assert line.gain == pytest.approx(once.gain, rel=0.05)  # the grid goes on turning


def test_bad_pairs_are_named() -> None:
    """Of two sizes, or smaller than a tile."""
    found = NoiseLevelFunction()
    with pytest.raises(ValueError, match='both must be alike'):
        found.add(np.zeros((40, 40), np.uint8), np.zeros((40, 41), np.uint8), 255, 0)
    with pytest.raises(ValueError, match='36 x 20 px is the least'):
        found.add(np.zeros((10, 40), np.uint8), np.zeros((10, 40), np.uint8), 255, 0)


def tracked_nees(
    method: str, noise: SensorNoise, *, online: bool, checked: bool = True,
    black_level: float = 0.0,
) -> tuple[float, int]:
    """
    Return the mean NEES of the bearings from 4 s on, and how many there are.

    With `online` the noise is that of the frames, else the pipeline's own check is left to see to
    it; without `checked` that is left out too.
    """
    light = Light(120.3, 90.2, 2.0, 80.0, in_step(60.0), reach_x=30.0, reach_y=20.0)
    scene = replace(
        SCENE, target=light, width=240, height=180, background=60.0 + black_level,
        sensor=Sensor(replace(NOISE, black_level=black_level)),
    )
    model = CameraModel.from_field_of_view(240, 180, 40.0)
    pipeline = Pipeline(model, noise=noise, method=method)
    measured = NoiseLevelFunction()
    seconds = set()

    def frames() -> Iterator[Frame]:
        for index in range(900):
            stamp_ns = scene.stamp_ns(index)
            yield Frame(scene.frame(index), stamp_ns, 255)
            pair = pipeline.segmenter.unlit_pair
            if online and pair is not None and stamp_ns // SECOND not in seconds:
                seconds.add(stamp_ns // SECOND)
                measured.add(*pair, 255, stamp_ns)
                line = measured.line()
                pipeline.noise = noise if line is None else line.noise

    locator = Locator(method)

    def unchecked() -> Iterator[Bearing]:
        for frame in frames():
            window = pipeline.segmenter.update(frame)
            if window is not None:
                yield window_to_bearing(window, model, locator=locator, noise=noise)[1]

    nees = []
    for bearing in pipeline.run(frames()) if checked else unchecked():
        index = round((bearing.stamp_ns - scene.stamp_ns(0)) * 60 / SECOND)
        truth = scene.truth(index)
        azimuth, elevation, _ = model.angles(truth.x, truth.y)
        error = np.array([bearing.azimuth - azimuth, bearing.elevation - elevation])
        if index >= 240:
            nees.append(error @ np.linalg.solve(bearing.covariance, error))
    return float(np.mean(nees)), len(nees)


@pytest.mark.parametrize(('method', 'factor'), [
    # Maximum likelihood grows its covariance by its own chi2, so that it can only be too wide.
    ('multi_gaussian_lm', 4.0), ('multi_gaussian_lm', 0.25), ('maximum_likelihood', 0.25),
])
def test_the_covariance_is_true_whatever_gain_is_configured(method: str, factor: float) -> None:
    """Four times off, the NEES is far from 2; with the noise measured on the way it is 2."""
    wrong = SensorNoise(factor * NOISE.gain, NOISE.read_noise)
    blind, _ = tracked_nees(method, wrong, online=False, checked=False)
    assert blind > 4.0 or blind < 1.0
    seen, _ = tracked_nees(method, wrong, online=False)
    assert 1.4 < seen < 2.8
    told, count = tracked_nees(method, wrong, online=True)
    assert count >= 300
    assert abs(told - 2.0) < 1.96 * 2.0 / np.sqrt(count)  # 95 % of means


def test_the_covariance_is_true_with_a_pedestal() -> None:
    """Of 64 DN, which are most of the level: unaware of it the covariance is far too large."""
    blind, _ = tracked_nees(
        'multi_gaussian_lm', NOISE, online=False, checked=False, black_level=64.0
    )
    assert blind < 1.6
    seen, _ = tracked_nees('multi_gaussian_lm', NOISE, online=False, black_level=64.0)
    assert 1.4 < seen < 2.8
    told, count = tracked_nees('multi_gaussian_lm', NOISE, online=True, black_level=64.0)
    assert count >= 300
    assert abs(told - 2.0) < 1.96 * 2.0 / np.sqrt(count)  # 95 % of means


@pytest.mark.parametrize(('curve', 'gain', 'told'), [
    ('rec709', 20.0, True), ('rec709', 5.0, True), ('limited', 20.0, False),
    ('limited', 200.0, False),
])
def test_a_gamma_curve_is_told(curve: str, gain: float, told: bool) -> None:
    """With what to do; of a linear sensor it is not, however little its variance grows."""
    random = np.random.default_rng(11)
    light = 6.0 * still_scene(240, 320)
    measured = NoiseLevelFunction()
    for k in range(4):
        pair = [seen(curve, light, random, SensorNoise(gain, 0.7)) for _ in range(2)]
        measured.add(pair[0], pair[1], 255, 10**9 * (k + 1))
    assert (measured.line() is None) is told, measured.reason
    assert ('applies a gamma curve' in measured.curved) is told
    assert ('calibrate response' in measured.reason) is told
