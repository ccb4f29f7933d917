"""Photon transfer: the simulator's truth within its own sigma, a real sensor's data sheet."""

from __future__ import annotations

from dataclasses import replace
import os
from pathlib import Path
from typing import Any

from blob_tracker.calibration.frame_pair import pair_of, PhotonTransferError
from blob_tracker.calibration.photon_transfer import photon_transfer, PhotonTransfer
from blob_tracker.location.noise import pixel_variance
from blob_tracker.simulation import FlatField, Sensor
from blob_tracker.types import SensorNoise
import cv2
import numpy as np
import pytest

DATA = Path(os.environ.get('BLOB_TRACKER_DATA', '')) / 'emva_001'
DRAWS = 100
# The mean of as many draws of chi-square with 2 degrees of freedom: 95 % lie within this of 2.
BOUND = 1.96 * 2.0 / np.sqrt(DRAWS)
LEVELS = (0.02, 0.1, 0.2, 0.35, 0.5, 0.65, 0.85, 1.1)  # of full scale above black
FIELD = FlatField(
    Sensor(SensorNoise(gain=3.6, read_noise=3.0, black_level=20.0), 12, prnu=0.01, dsnu=0.5),
    width=320, height=240,
)


def of_noise(noise: SensorNoise, **changes: Any) -> FlatField:
    """Return the field with another sensor."""
    return replace(FIELD, sensor=replace(FIELD.sensor, noise=noise, **changes))


def pairs_of(field: FlatField, random: np.random.Generator, levels=LEVELS, darks: int = 4):
    """Return the pairs of a field at these parts of full scale, and dark ones."""
    top = field.sensor.saturation - field.sensor.noise.black_level
    return [
        pair_of(
            field.frame(level * top, random), field.frame(level * top, random),
            dark=level == 0.0, exposure=level,
        )
        for level in (*(0.0,) * darks, *levels)
    ]


def drawn(random: np.random.Generator) -> FlatField:
    """Return a sensor of any kind."""
    gain = float(np.exp(random.uniform(np.log(0.5), np.log(200.0))))
    read_noise = float(np.exp(random.uniform(np.log(0.3), np.log(5.0))))
    clipped = random.random() < 0.25  # a quarter of the sensors has its dark pixels at 0 DN
    bits = int(random.choice([8, 10, 12, 16]))
    saturation = 2**bits - 1
    black_level = 0.0
    if not clipped:
        # Up to 300 DN, but of 8 bits no more than a tenth.
        pedestal = random.uniform(0.0, min(300.0, 0.1 * saturation))
        black_level = max(pedestal, 6.0 * read_noise + 1.0)
    return FlatField(
        Sensor(
            SensorNoise(gain, read_noise, black_level),
            bits,
            prnu=random.uniform(0.0, 0.02),
            dsnu=0.0 if clipped else random.uniform(0.1, 0.5),
            full_well=np.inf if random.random() < 0.5 else 0.9 * saturation * gain,
            seed=int(random.integers(2**31)),
        ),
        width=160,
        height=120,
    )


def test_the_truth_is_within_the_sigmas() -> None:
    """Of 100 sensors the line, and gain and dark noise, are right under their covariances."""
    random = np.random.default_rng(1288)
    squares = []
    for _ in range(DRAWS):
        field = drawn(random)
        found = photon_transfer(pairs_of(field, random))
        line, noise = found.line, field.sensor.noise
        squares.append([
            error @ np.linalg.solve(covariance, error)
            for error, covariance in (
                (
                    np.array([
                        line.slope - 1 / noise.gain, line.foot - noise.read_noise**2 - 1 / 12
                    ]),
                    line.covariance,
                ),
                (
                    np.array([
                        found.noise.gain - noise.gain, found.noise.read_noise - noise.read_noise
                    ]),
                    line.noise_covariance,
                ),
            )
        ])
        # A full well shows as the last exposure below it: 0.85 of full scale.
        assert 0.84 * field.sensor.saturation <= found.saturation <= field.sensor.saturation
    np.testing.assert_allclose(np.mean(squares, axis=0), 2.0, atol=BOUND)


@pytest.fixture(scope='module')
def sensor() -> PhotonTransfer:
    """Return the photon transfer of FIELD."""
    return photon_transfer(pairs_of(FIELD, np.random.default_rng(3)))


def test_non_uniformity_and_saturation(sensor: PhotonTransfer) -> None:
    """PRNU, DSNU, black level, capacity and linearity are those of the field."""
    # DSNU: four sigma of the draw of 76,800 pixels, which is not in the sigma, are 1 %.
    for pair, truth, draw in (
        (sensor.prnu, 0.01, 0.0001),
        (sensor.dsnu, 0.5 * 3.6, 0.02),
        (sensor.black_level, 20.0, 0.01),
    ):
        assert pair is not None and 0.0 < pair[1] < 0.2 * truth
        assert abs(pair[0] - truth) < 4.0 * pair[1] + draw
    assert sensor.saturation == 4095 and sensor.saturation_seen
    # The next exposure, where all are clipped, is sqrt(12) sigma further on.
    assert 0.0 < 3.6 * 4075 - sensor.capacity[0] < np.sqrt(12.0) * sensor.capacity[1]
    assert sensor.linearity_error is not None and sensor.linearity_error[0] < 0.001
    assert not sensor.warnings


def test_the_locator_gets_the_three_apart(sensor: PhotonTransfer) -> None:
    """Gain, dark noise and black level are the field's; 76,800 pixels tell a variance to 0.5 %."""
    assert sensor.noise.gain == pytest.approx(3.6, rel=0.01)
    assert sensor.noise.read_noise == pytest.approx(3.0, rel=0.01)
    assert sensor.noise.black_level == pytest.approx(20.0, abs=0.05)


def test_without_dark_frames_the_variance_is_right() -> None:
    """The foot of the line tells no black level; its noise is that of the pixels all the same."""
    field = of_noise(SensorNoise(3.6, 3.0, 240.0))
    found = photon_transfer(pairs_of(field, np.random.default_rng(9), darks=0))
    assert found.noise.read_noise == 0.0 and 0.0 < found.noise.black_level < 240.0
    levels = np.array([300.0, 1000.0, 2500.0])
    np.testing.assert_allclose(
        pixel_variance(levels, found.noise), pixel_variance(levels, field.sensor.noise), rtol=0.02
    )


def test_full_well_below_the_converter() -> None:
    """A well that is full at 2,500 DN shows as the peak of the curve; no DN is clipped."""
    levels = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.9)
    noise = FIELD.sensor.noise
    field = of_noise(noise, full_well=2500.0 * noise.gain)
    found = photon_transfer(pairs_of(field, np.random.default_rng(4), levels))
    assert abs(found.saturation - 2500) < 300  # a step of the exposure is 400 DN
    assert found.line.gain == pytest.approx(3.6, rel=0.02)


def test_dark_pixels_at_zero_are_left_out_and_warned_of() -> None:
    """Half of the dark noise is cut off; the line finds it in the bright frames."""
    field = of_noise(SensorNoise(3.6, 3.0))
    found = photon_transfer(pairs_of(field, np.random.default_rng(5), (0.003, *LEVELS)))
    assert any('clipped at 0 DN' in warning for warning in found.warnings)
    sigma = np.sqrt(found.line.noise_covariance[1, 1])
    assert abs(found.line.read_noise - 3.0) < 3.0 * sigma < 0.6
    assert found.dsnu is None and found.black_level is None


def test_a_hot_pixel_costs_no_pair() -> None:
    """One of 76,800 at full scale in every frame: line and black level are as without it."""
    random = np.random.default_rng(10)
    pairs = []
    for level in (0, 0, 300, 900, 1800, 2500):
        two = [FIELD.frame(level, random) for _ in range(2)]
        for each in two:
            each[100, 100] = FIELD.sensor.saturation
        pairs.append(pair_of(*two, dark=level == 0))
    found = photon_transfer(pairs)
    assert found.used.all()
    # Three sigma of the gain from 76,800 pixels at four levels.
    assert found.noise.gain == pytest.approx(3.6, rel=0.015)
    # Dark noise by the dark pairs: to 0.3 % of its variance; 4075 DN / 76,800 is 0.053 DN.
    assert found.noise.read_noise == pytest.approx(3.0, rel=0.01)
    assert found.black_level is not None and found.black_level[0] == pytest.approx(20.05, abs=0.03)
    # More than the variance can bear: the pairs are left out.
    clipped = [replace(each, at_highest=0.001) for each in pairs]
    with pytest.raises(PhotonTransferError, match='0 of 6 pairs show their noise'):
        photon_transfer(clipped)


def test_constant_dark_frames_tell_the_black_level() -> None:
    """Rounding hides the read noise: the level is known to the rounding, 0.29 DN."""
    field = of_noise(SensorNoise(3.6, 0.05, 16.0), dsnu=0.0)
    found = photon_transfer(pairs_of(field, np.random.default_rng(11)))
    assert found.black_level == (16.0, pytest.approx(np.sqrt(1 / 12), rel=1e-6))
    assert found.noise.black_level == 16.0
    assert any('rounding hides' in each for each in found.warnings)


def test_processed_frames_are_warned_of() -> None:
    """Blurred frames by their correlated noise, shifted bits by their step."""
    random = np.random.default_rng(6)
    top = FIELD.sensor.saturation - FIELD.sensor.noise.black_level
    frames = [[FIELD.frame(part * top, random) for _ in range(2)] for part in (0.1, 0.3, 0.5)]
    blurred = [
        pair_of(*(cv2.GaussianBlur(each, (3, 3), 0.8).astype(each.dtype) for each in two))
        for two in frames
    ]
    assert any('compressed, demosaiced' in each for each in photon_transfer(blurred).warnings)
    shifted = [pair_of(*(16 * each for each in two)) for two in frames]
    assert any('multiples of 16' in each for each in photon_transfer(shifted).warnings)


def gamma(image: np.ndarray, exponent: float) -> np.ndarray:
    """Return 8 bits of 12 with a gamma curve."""
    return np.rint(255.0 * (image / 4095.0) ** exponent).astype(np.uint8)


def test_gamma_is_refused_or_warned_of() -> None:
    """Under sRGB's the variance falls with the level; a weaker one bends the curve."""
    field = of_noise(SensorNoise(0.4, 3.0, 20.0))
    random = np.random.default_rng(7)
    for exponent, says in ((1 / 2.2, 'does not grow'), (0.8, 'not linear')):
        pairs = [
            pair_of(*(gamma(field.frame(4000.0 * part, random), exponent) for _ in range(2)),
                    exposure=part)
            for part in (0.05, 0.1, 0.2, 0.3, 0.4, 0.5)
        ]
        if says == 'does not grow':
            with pytest.raises(PhotonTransferError, match=says):
                photon_transfer(pairs)
        else:
            warnings = photon_transfer(pairs).warnings
            assert any(says in each for each in warnings)
            assert any('off a line over the exposure' in each for each in warnings)


def test_what_cannot_be_is_said() -> None:
    """All clipped, one level, no bright frame, frames that differ in size."""
    random = np.random.default_rng(8)
    for levels, darks, says in (
        ((1.3, 1.5), 1, 'every bright pair is clipped at 4095 DN; expose shorter'),
        ((0.3, 0.3), 0, 'all at one level; take pairs at several exposures'),
        ((), 2, 'no bright frames'),
    ):
        with pytest.raises(PhotonTransferError, match=says):
            photon_transfer(pairs_of(FIELD, random, levels, darks))
    with pytest.raises(PhotonTransferError, match='both frames must be of one size'):
        pair_of(np.zeros((20, 20), np.uint8), np.zeros((20, 30), np.uint8))


@pytest.mark.skipif(
    not (DATA / 'index.csv').is_file(),
    reason='BLOB_TRACKER_DATA does not name a folder with emva_001/',
)
def test_real_sensor() -> None:
    """Set 001 of EMVA 1288: K 0.280 DN/e-, dark noise 3.07 DN, PRNU 0.26 %."""
    pairs = []
    for step in range(0, 45, 5):
        for kind in 'bd':
            two = (DATA / f'{kind}_{step:03d}_snap_00{shot}.png' for shot in (1, 2))
            images: list[Any] = [cv2.imread(str(each), cv2.IMREAD_UNCHANGED) for each in two]
            pairs.append(pair_of(images[0], images[1], dark=kind == 'd', exposure=float(step)))
    found = photon_transfer(pairs)
    assert found.line.slope == pytest.approx(0.280, rel=0.02)
    # By the standard on all 50 exposures 0.2801; its line bends by 1 %.
    assert found.system_gain is not None
    assert found.system_gain[0] == pytest.approx(0.2801, rel=0.01)
    assert abs(found.system_gain[0] - 0.2801) < 2.0 * found.system_gain[1]
    assert abs(found.line.slope - 0.2801) < 2.0 * np.sqrt(found.line.covariance[0, 0])
    assert found.noise.read_noise == pytest.approx(3.07, rel=0.03)
    assert not any('black level' in each for each in found.warnings)
    assert found.prnu is not None
    # Their filter may differ; 5 % of it is twice the sigma of 307,200 pixels.
    assert found.prnu[0] == pytest.approx(0.0026, rel=0.05)
    assert found.saturation == 4095
