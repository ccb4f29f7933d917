"""A noise that is not as configured is named and put right; a right one stays, bit for bit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from blob_tracker.location import locate
from blob_tracker.location.noise_check import NoiseCheck
from blob_tracker.location.pulse import integrated_profile
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import SensorNoise, Window
import numpy as np
import pytest
from support.late_kernels import run_alone

CONFIGURED = SensorNoise(gain=10.0, read_noise=1.0)
BACKGROUND, PEAK, SIGMA, SIZE = 30.0, 100.0, 1.5, 15  # DN, DN, px, px
SETTLED = 60  # windows after which a contradiction by 1.5 must be known
IN_ORDER = """
import numpy as np
from blob_tracker.location import compile_ahead, locate
from blob_tracker.location.noise_check import NoiseCheck
from location.test_noise_check import CONFIGURED, windows
from support.late_kernels import late_kernels

compile_ahead(['maximum_likelihood'])
late = late_kernels()
for options in ({}, {'looks': 4}, {'texture': 8.0, 'speed': 0.7}):
    check = NoiseCheck(CONFIGURED)
    for window, x, y in windows(CONFIGURED, np.random.default_rng(1), count=100, **options):
        location = check.doubted(window, locate(window, noise=check.noise))
        check.add(window, location)
assert not late, late
"""


def windows(
    noise: SensorNoise, random: np.random.Generator, *, count: int = 400, looks: int = 1,
    texture: float = 0.0, speed: float = 0.0,
) -> Iterator[tuple[Window, float, float]]:
    """
    Yield windows of a light with its place in the frame, px.

    The wall behind it has white `texture`, DN, and the light goes by at `speed` px a window.
    """
    wall = noise.black_level + BACKGROUND + texture * random.standard_normal((SIZE + 5, 400))
    for index in range(count):
        x, y = 20.0 + random.uniform(-1, 1) + speed * index % 360, 9.5 + random.uniform(-1, 1)
        x0, y0 = round(x) - SIZE // 2, round(y) - SIZE // 2
        unlit = wall[y0:y0 + SIZE, x0:x0 + SIZE]
        pulse = PEAK * np.outer(
            integrated_profile(SIZE, y - y0, SIGMA)[0], integrated_profile(SIZE, x - x0, SIGMA)[0]
        )
        lit, dark = (
            np.asarray([expose(mean, noise, random, saturation=255) for _ in range(looks)])
            .sum(axis=0).astype(np.uint16)
            for mean in (unlit + pulse, unlit)
        )
        yield Window(
            lit, dark, x0, y0, round(index * 1e9 / 30), 255 * looks, looks=looks
        ), x, y


def nees(
    noise: SensorNoise, seed: int = 1, **options: float
) -> tuple[float, NoiseCheck]:
    """Return the mean squared error over the covariance once it is settled, and the check."""
    check, squares = NoiseCheck(CONFIGURED), []
    for index, (window, x, y) in enumerate(
        windows(noise, np.random.default_rng(seed), **options)  # type: ignore[arg-type]
    ):
        location = locate(window, noise=check.noise)
        if index >= SETTLED:
            error = np.array([location.x - x, location.y - y])
            squares.append(error @ np.linalg.solve(location.covariance, error))
        check.add(window, location)
    return float(np.mean(squares)), check


@pytest.mark.parametrize(('noise', 'before'), [
    (replace(CONFIGURED, black_level=100.0), 0.7),
    (replace(CONFIGURED, gain=5.0), 3.1),
    (replace(CONFIGURED, gain=20.0), 1.1),
    (replace(CONFIGURED, read_noise=3.0), 2.4),
], ids=['pedestal', 'half the gain', 'twice the gain', 'read noise'])
def test_a_wrong_noise_is_named_and_put_right(noise: SensorNoise, before: float) -> None:
    """On an even wall, which tells one level only; the NEES was `before`."""
    found, check = nees(noise)
    # Three sigma of 340 draws are 0.33; the levels' variances are known to some per cent.
    assert found == pytest.approx(2.0, abs=0.45)
    assert 'Set noise.gain, noise.read_noise and noise.black_level' in check.warning
    assert ('takes out noise' in check.warning) == (before < 2.0)
    if noise.read_noise == CONFIGURED.read_noise:
        assert check.noise.gain == pytest.approx(noise.gain, rel=0.25)
        assert check.noise.black_level == pytest.approx(noise.black_level, abs=6.0)


@pytest.mark.parametrize('options', [
    {}, {'texture': 4.0}, {'texture': 4.0, 'speed': 1.0}, {'looks': 4},
], ids=['even', 'texture', 'a light that moves', 'looks'])
def test_a_right_noise_stays(options: dict[str, float]) -> None:
    """Over 6 seeds, with all that the windows may show; 10 % off is as good as right."""
    for seed in range(6):
        for noise in (CONFIGURED, replace(CONFIGURED, gain=9.0)):
            _, check = nees(noise, seed, count=150, **options)
            assert check.noise is CONFIGURED and not check.warning


def test_looks_are_taken_apart() -> None:
    """The noise of a sum of four is told as that of one frame."""
    found, check = nees(replace(CONFIGURED, gain=5.0), looks=4, count=200)
    assert found == pytest.approx(2.0, abs=0.7)  # three sigma of 140 draws, and the noise's own
    assert check.noise.gain == pytest.approx(5.0, rel=0.25)


@pytest.mark.parametrize('kind', ['blurred', 'constant', 'far apart', 'no unlit'])
def test_what_tells_no_noise_is_left_alone(kind: str) -> None:
    """Warped pixels, ones that rounding holds, windows seconds apart, or none to compare."""
    check = NoiseCheck(CONFIGURED)
    for index, (window, _, _) in enumerate(
        windows(replace(CONFIGURED, black_level=100.0), np.random.default_rng(2), count=100)
    ):
        location = locate(window, noise=CONFIGURED)
        unlit = np.asarray(window.unlit, dtype=float)
        if kind == 'blurred':
            half = 0.5 * (unlit + np.roll(unlit, 1, axis=1))
            window = replace(window, unlit=np.rint(half))
        elif kind == 'constant':
            window = replace(window, unlit=np.full_like(unlit, 130.0 + index % 2))
        elif kind == 'far apart':
            window = replace(window, stamp_ns=index * 2 * 10**9)
        else:
            window = replace(window, unlit=None)
        check.add(window, location)
    assert check.noise is CONFIGURED
    # What was interpolated says nothing of the noise, and much of the picture.
    assert ('noise of neighbouring pixels is alike' in check.warning) == (kind == 'blurred')


def test_compile_ahead_leaves_nothing_to_compile() -> None:
    """No window waits for the compiler because it is looked at: in a process of its own."""
    run_alone(IN_ORDER)
