"""Points to lights: those that blink are found, named as lamps where they are, and told apart."""

from __future__ import annotations

from blob_tracker.blinking.patterns import code, look, Pattern, wave
from blob_tracker.blinking.recognition import Brightness, recognise, Rhythm
from blob_tracker.blinking.survey import frame_times, mains_alias, Survey
from blob_tracker.blinking.tracker import MOST_POINTS
import numpy as np
import pytest

RATE = 60.0
FULL = 1000.0
EXPOSURE = 0.5 / RATE


def watched(
    patterns: list[Pattern], count: int, *, speed: float = 0.0, lamps: int = 0, crowd: int = 0
) -> Survey:
    """Return a survey of lights that go in circles, of lamps, and of points of no light."""
    random = np.random.default_rng(1)
    tables = [look(pattern, 4096, EXPOSURE)[0] for pattern in patterns]
    survey = Survey(count)
    for k in range(count):
        rows = []
        for index, (pattern, table) in enumerate(zip(patterns, tables)):
            share = table[int((k / RATE / pattern.period + 0.3) % 1.0 * 4096)]
            turn = speed * k / 60.0 + index
            if share > 0.05:
                rows.append([100.0 + 120.0 * index + 60.0 * np.cos(turn),
                             200.0 + 60.0 * np.sin(turn), share * FULL])
        rows += [[50.0 + 60.0 * each, 20.0, FULL] for each in range(lamps)]
        rows += [[*random.uniform(0.0, 700.0, 2), 0.5 * FULL] for _ in range(crowd)]
        places = np.array(rows).reshape(-1, 3)
        table = np.zeros((len(rows), 7))
        table[:, :2] = places[:, :2] + 0.05 * random.standard_normal((len(rows), 2))
        table[:, [2, 4]], table[:, 6] = 0.0025, 10.0
        table[:, 5] = places[:, 2] * (1.0 + 0.02 * random.standard_normal(len(rows)))
        survey.push(table, round(1e9 * k / RATE), 0.05 * FULL)
    return survey


def test_lights_of_all_kinds_in_motion_among_lamps() -> None:
    """Waves and codes, 3 px a frame; steady lamps are not listed."""
    lights = watched(
        [wave('a', 6.0, 0.5), code('b', '1101000', 59.7), wave('c', 13.7, 0.5)], 180, speed=3.0,
        lamps=3,
    ).lights(EXPOSURE)
    found = {light.rhythm.bits or round(light.frequency, 1) for light in lights}
    assert found == {6.0, '1101000', 13.7}
    for light in lights:
        if light.rhythm.bits:
            assert light.bits_per_second == pytest.approx(59.7, abs=0.03)
        assert light.mains == 0.0 and not light.alternates


def test_every_other_frame() -> None:
    """It is known as what the mode alternate is for."""
    light, = watched([wave('a', 30.0, 0.5)], 60).lights(EXPOSURE)
    assert light.alternates and light.aliases == ()
    light, = watched([wave('a', 29.9, 0.5)], 600).lights(EXPOSURE)  # a beat
    assert light.alternates and light.frequency == pytest.approx(29.9, abs=2e-3)


def test_a_light_that_is_lost_and_found_is_one() -> None:
    """The shorter piece is left out."""
    survey = watched([code('b', '1101000', 60.0)], 160)
    for k in range(60, 130):  # longer than a path lives
        stamp, points, least = survey._frames[k]
        survey._frames[k] = stamp, points[:0], least
    light, = survey.lights(EXPOSURE)
    assert light.rhythm.bits == '1101000' and light.path.frames[-1] < 60


def test_memory_is_bounded() -> None:
    """The last frames are kept, of each the brightest points."""
    survey = watched([wave('a', 6.0, 0.5)], 20, crowd=500)
    assert survey.crowded
    for _, points, _ in survey._frames:
        assert len(points) == MOST_POINTS and points[:, 5].max() < 1.2 * FULL
    short = Survey(5)
    for k in range(9):
        assert short.full == (k >= 5)
        short.push(np.zeros((0, 7)), k * 10**7, 1.0)
        assert short.longest == pytest.approx(0.04 if k else np.inf)
    assert short.seconds == pytest.approx(0.04)


def test_which_points_are_kept_is_told() -> None:
    """The brightest, in their order: what goes with them is cut in the same way."""
    points = np.zeros((3 * MOST_POINTS, 7))
    points[:, 5] = np.random.default_rng(1).permutation(len(points))
    kept = Survey(5).push(points, 0, 1.0)
    np.testing.assert_array_equal(kept, np.flatnonzero(points[:, 5] >= 2 * MOST_POINTS))


@pytest.mark.parametrize('flicker', [0.0, 0.3])
def test_what_is_never_dark_comes_last(
    flicker: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Lamps that are even are not looked at, others after the lights; both are bounded."""
    survey = watched([wave('a', 6.0, 0.5)], 120, lamps=10)
    random = np.random.default_rng(2)
    looked = []
    for _, points, _ in survey._frames:
        lamps = points[:, 1] < 100.0
        points[lamps, 5] *= 1.0 + flicker * random.standard_normal(lamps.sum()).clip(-2.0, 2.0)

    def counted(brightness: Brightness, *rest: float, **more: bool) -> Rhythm:
        looked.append(brightness)
        return recognise(brightness, *rest, **more)

    monkeypatch.setattr('blob_tracker.blinking.survey.recognise', counted)
    light = survey.lights(EXPOSURE, sigmas=False, most=3)[0]
    assert light.frequency == pytest.approx(6.0, abs=0.01)
    assert len(looked) == (3 if flicker else 1)


def test_500_points_of_chance_are_no_light() -> None:
    """No name is given where nothing keeps a rate."""
    lights = watched([], 25, crowd=500).lights(EXPOSURE, sigmas=False)
    assert not [light for light in lights if light.rhythm.kind in ('wave', 'code')]


@pytest.mark.parametrize('frequency, rate, mains', [
    (20.0, 60.0, 100.0), (10.0, 30.0, 100.0), (20.1, 50.0, 120.0), (10.0, 60.0, 0.0),
])
def test_lamps_on_the_mains(frequency: float, rate: float, mains: float) -> None:
    """A lamp of 100 or 120 Hz is seen at |f - k rate|."""
    assert mains_alias(frequency, 0.01, rate) == mains


def test_frames_are_counted_where_the_camera_keeps_its_rate() -> None:
    """Stamps that jitter by a twentieth of the interval do not matter, dropped frames do."""
    random = np.random.default_rng(1)
    number = np.delete(np.arange(200), [20, 21, 90])
    stamps = np.rint(1e9 / RATE * (number + 0.05 * random.standard_normal(len(number))))
    clock, interval = frame_times(stamps.astype(np.int64))
    np.testing.assert_array_equal(clock, number)
    assert interval == pytest.approx(1.0 / RATE, rel=1e-3)
    uneven = np.cumsum(random.uniform(0.5, 1.5, 200)) / RATE
    clock, interval = frame_times(np.rint(1e9 * uneven).astype(np.int64))
    np.testing.assert_allclose(np.diff(clock) * interval, np.diff(uneven), atol=1e-8)
