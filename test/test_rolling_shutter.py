"""A light that moves while a rolling shutter reads its lines: its place is true at its stamp."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from blob_tracker.location import Locator
from blob_tracker.segmentation import flash_by_name, Segmenter
from blob_tracker.simulation.sensor import expose
from blob_tracker.types import Frame, SensorNoise, Window
import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.special import erf
from support.flashes import nees

Array = NDArray[np.float64]

HEIGHT, WIDTH = 240, 120  # px
RATE, EXPOSURE = 40.0, 4e-3  # Hz, s
LINE = 20e-3 / HEIGHT  # s: a readout of 20 ms
SIGMA, PEAK, BACKGROUND = 1.5, 100.0, 20.0  # px, DN, DN
NOISE = SensorNoise(gain=10.0, read_noise=1.0)
SPEED = 3.0  # px a frame, at the top
HALF, PARTS = 14, 21  # px about the light that are drawn; instants of an exposure
CODE = '1101011000'
BITS_PER_SECOND = 0.995 * RATE
SETTLED = 40  # frames


def place(time: Array) -> tuple[Array, Array]:
    """Return where the light is, px."""
    angle = SPEED * RATE / np.sqrt(2.0) * time
    return 60.0 + 40.0 * np.sin(angle / 40.0 + 0.3), 120.0 + 90.0 * np.sin(angle / 90.0)


class Way(NamedTuple):
    """A mode of the segmenter, its options, and how its light shines: from times to 0 or 1."""

    mode: str
    options: dict[str, object]
    light: Callable[[Array], Array]


def in_step(bits: str, rate: float) -> Callable[[Array], Array]:
    """Return a light that sends bits, the first from the begin of the first line's exposure on."""
    values = np.array([float(bit) for bit in bits])

    def shines(time: Array) -> Array:
        index = np.floor((time + 0.5 * EXPOSURE + 1e-5) * rate).astype(int)
        return np.asarray(values[index % len(values)])

    return shines


WAYS = {
    'alternate': Way('alternate', {}, in_step('10', RATE)),
    'coded': Way('coded', {'codes': {'a': CODE}}, in_step(CODE, RATE)),
    'coded, running free': Way(
        'coded',
        {'codes': {'a': CODE}, 'bits_per_second': BITS_PER_SECOND},
        in_step(CODE, BITS_PER_SECOND),
    ),
}


def picture(time: float, light: Callable[[Array], Array], random: np.random.Generator) -> Frame:
    """Return the frame whose first line is exposed about a time, s."""
    mean = np.full((HEIGHT, WIDTH), BACKGROUND)
    seen = time
    for _ in range(5):
        column, row = place(np.array(seen))
        seen = time + LINE * float(row)
    top, left = int(row) - HALF, int(column) - HALF
    rows, columns = np.arange(top, top + 2.0 * HALF + 1), np.arange(left, left + 2.0 * HALF + 1)
    parts = EXPOSURE * ((np.arange(PARTS) + 0.5) / PARTS - 0.5)
    times = time + LINE * rows[:, None] + parts
    x, y = place(times)

    def pixels(at: Array, centre: Array) -> Array:
        away, width = at - centre, np.sqrt(2.0) * SIGMA
        return np.asarray(0.5 * (erf((away + 0.5) / width) - erf((away - 0.5) / width)))

    down = pixels(rows[:, None], y) * light(times)
    across = pixels(columns[None, None], x[:, :, None])
    mean[top:top + len(rows), left:left + len(columns)] += (
        2.0 * np.pi * SIGMA**2 * PEAK * (down[:, :, None] * across).mean(axis=1)
    )
    return Frame(
        expose(mean, NOISE, random), 10**9 + round(1e9 * time), 255,
        exposure_ns=round(1e9 * EXPOSURE), line_time_ns=1e9 * LINE,
    )


@pytest.mark.parametrize('way', WAYS)
def test_the_place_is_that_of_the_stamp_with_a_true_covariance(way: str) -> None:
    """By the line of the light: 300 px on the stamp of the first line would be off by 1 px."""
    mode, options, light = WAYS[way]
    random = np.random.default_rng(3)
    segmenter, locator = Segmenter(flash=flash_by_name(mode=mode, **options)), Locator()
    errors, covariances, lines = [], [], []
    for index in range(SETTLED + 120):
        frame = picture(index / RATE, light, random)
        for name, window in segmenter.sightings(frame):
            found = locator.locate(window, noise=NOISE, light=name)
            if index < SETTLED:
                continue
            x, y = place(np.array((found.stamp_ns - 10**9) / 1e9))
            errors.append([found.x - x, found.y - y])
            covariances.append(found.covariance)
            lines.append((found.stamp_ns - frame.stamp_ns) / (1e9 * LINE) - found.y)
    assert len(errors) >= 55
    # Of N pairs of errors the mean of the NEES is 2 +- 2 / sqrt(N): 4 standard deviations.
    assert nees(errors, covariances) == pytest.approx(2.0, abs=8.0 / np.sqrt(len(errors)))
    if way == 'alternate':
        assert np.abs(lines).max() < 1e-3  # of a line: ns of rounding


STILL = {
    'steady': Way('steady', {}, lambda time: np.ones_like(time)),
    'lock_in': Way('lock_in', {'frequency': RATE / 4.0, 'frames': 16}, in_step('1100', RATE)),
    'periodic': Way('periodic', {'frequency': RATE / 4.0}, in_step('1100', RATE)),
    'alternate': WAYS['alternate'],
    'coded': WAYS['coded'],
}


@pytest.mark.parametrize('line_time', [LINE, -LINE])
@pytest.mark.parametrize('way', STILL)
def test_every_mode_stamps_a_window_by_its_middle_line(way: str, line_time: float) -> None:
    """And with a global shutter as before, by the frame: the same windows of the same pixels."""
    mode, options, light = STILL[way]

    def windows(line_time_ns: float) -> list[Window]:
        random = np.random.default_rng(5)
        segmenter = Segmenter(flash=flash_by_name(mode=mode, **options))
        found = []
        for index in range(33):
            mean = np.full((HEIGHT, WIDTH), BACKGROUND)
            pulse = np.exp(-0.5 * ((np.arange(15) - 7.0) / SIGMA) ** 2)
            on = float(light(np.array(index / RATE)))
            mean[180:195, 40:55] += on * PEAK * np.outer(pulse, pulse)
            found += segmenter.sightings(Frame(
                expose(mean, NOISE, random), round(1e9 * index / RATE), 255,
                exposure_ns=round(1e9 * EXPOSURE), line_time_ns=line_time_ns,
            ))
        return [each.window for each in found]

    with_global, with_rolling = windows(0.0), windows(1e9 * line_time)
    assert len(with_global) == len(with_rolling) >= 2
    for one, other in zip(with_global, with_rolling):
        assert (one.x0, one.y0, one.lit.shape) == (other.x0, other.y0, other.lit.shape)
        assert other.line_time_ns == 1e9 * line_time
        middle = other.y0 + 0.5 * (other.lit.shape[0] - 1)
        assert other.stamp_ns - one.stamp_ns == pytest.approx(1e9 * line_time * middle, abs=1.0)
