"""Coded and periodic lights are named in every lit frame, in motion too, at the right instant."""

from __future__ import annotations

from blob_tracker.location import Locator
from blob_tracker.segmentation import flash_by_name, Segmenter
from blob_tracker.segmentation.blink import Coded, Periodic
from blob_tracker.segmentation.patterns import check_patterns, rate_fault, twin_fault
from blob_tracker.simulation import coded, Light, periodic, Scene
from blob_tracker.types import Frame, SensorNoise
import numpy as np
import pytest

# Neither is a shift of the other.
CODES = {'port': '1101000', 'starboard': '1111010'}
RATE, EXPOSURE = 60.0, 0.3  # frames a second, and part of the frame interval
PLACES = {'port': (40.2, 30.7), 'starboard': (110.6, 80.1)}
ROUNDS = 10


def before_a_wall(*lights: Light) -> Scene:
    """Return a scene of these lights."""
    return Scene(
        elements=lights, width=160, height=120, rate=RATE, exposure=EXPOSURE, texture=0.0
    )


def lights(codes: dict[str, str], frames_per_bit: int = 1) -> Scene:
    """Return one light for each code; bits change between the exposures."""
    return before_a_wall(*(
        Light(*PLACES[name], 2.0, 120.0, coded(bits, frames_per_bit / RATE, start=0.5 / RATE))
        for name, bits in codes.items()
    ))


def flash(codes: dict[str, str], frames_per_bit: int = 1) -> Segmenter:
    """Return a segmenter for the codes."""
    return Segmenter(flash=Coded(
        codes=codes, frames_per_bit=frames_per_bit, exposure=EXPOSURE / RATE
    ))


def names(segmenter: Segmenter, scene: Scene, indices: range) -> dict[str, list[int]]:
    """Feed frames; return in which each light was given, each time at its place."""
    found: dict[str, list[int]] = {}
    for index in indices:
        frame = Frame(scene.frame(index), scene.stamp_ns(index), 255)
        for name, window in segmenter.sightings(frame):
            height, width = window.lit.shape
            x, y = PLACES[name]
            assert abs(window.x0 + (width - 1) / 2 - x) <= 1.5
            assert abs(window.y0 + (height - 1) / 2 - y) <= 1.5
            # In step: seen in the middle. While the phase is being found an edge is possible.
            late = abs(window.stamp_ns - scene.stamp_ns(index))
            assert late <= 100_000 and (late == 0 or index < indices[0] + 50)
            found.setdefault(name, []).append(index)
    return found


@pytest.mark.parametrize('frames_per_bit', [1, 3])
def test_each_light_is_named_in_every_lit_frame(frames_per_bit: int) -> None:
    """From the third round on at the latest, and in no dark frame."""
    turn = 7 * frames_per_bit
    found = names(
        flash(CODES, frames_per_bit), lights(CODES, frames_per_bit), range(ROUNDS * turn)
    )
    for name, bits in CODES.items():
        lit = [
            k for k in range(2 * turn, ROUNDS * turn)
            if bits[int((k - 0.5 + 1e-9) // frames_per_bit) % 7] == '1'
        ]
        assert [k for k in found[name] if k >= 2 * turn] == lit


def test_other_blinking_is_no_light() -> None:
    """Neither a mains-like flicker nor a light that is switched on once has a code."""
    scene = before_a_wall(
        Light(40.2, 30.7, 2.0, 120.0, periodic(0.31 * RATE, 0.5)),
        Light(110.6, 80.1, 2.0, 120.0, lambda times: (times > 0.3).astype(float)),
    )
    segmenter = flash(CODES)
    assert names(segmenter, scene, range(90)) == {}
    assert 'none is due and of a known pattern' in segmenter.reason


def test_a_gap_in_the_frames_starts_reading_afresh() -> None:
    """No name until enough of a code was seen again."""
    scene, segmenter = lights(CODES), flash(CODES)
    assert names(segmenter, scene, range(30))
    assert names(segmenter, scene, range(60, 65)) == {}


def test_bits_are_read_in_any_phase() -> None:
    """A start in the middle of the code is read as well as one at its beginning."""
    scene = lights(CODES)
    for first in range(1, 7):
        assert names(flash(CODES), scene, range(first, first + 25)).keys() == CODES.keys()


@pytest.mark.parametrize('speed', [0.0, 3.0, 10.0])
def test_a_free_running_light_in_motion_is_placed_where_it_was_at_the_stamp(speed: float) -> None:
    """NEES/2 is 1 within the chi-square of 100 and more placed windows, with partly lit ones."""
    bits, rate = '1101011000', 59.7
    reach = 160.0
    omega = max(speed, 1e-9) * RATE / reach

    def x(time: float) -> float:
        return 220.0 + (reach * np.sin(omega * time) if speed else 0.0)

    random = np.random.default_rng(7)
    segmenter = Segmenter(flash=Coded(
        codes={'only': bits}, bits_per_second=rate, exposure=0.5 / RATE
    ))
    locator = Locator()
    offsets = ((np.arange(200) + 0.5) / 200 - 0.5) * 0.5 / RATE
    columns, rows = np.arange(440), np.arange(60)
    squares, lit, found, partly = [], 0, 0, 0
    for index in range(260):
        times = index / RATE + offsets
        on = np.array([b == '1' for b in bits])[(times * rate).astype(int) % 10]
        image = np.full((60, 440), 20.0) + random.standard_normal((60, 440))
        for time in times[on]:
            across = np.exp(-0.5 * ((columns - x(time)) / 1.5) ** 2)
            image += 0.5 * np.outer(np.exp(-0.5 * ((rows - 30.3) / 1.5) ** 2), across)
        frame = Frame(np.rint(np.clip(image, 0, 255)).astype(np.uint8), round(
            1e9 * index / RATE), 255)
        sightings = segmenter.sightings(frame)
        if index < 30 or on.mean() < 0.1:
            continue
        lit += 1
        for _, window in sightings:
            found += 1
            partly += on.mean() < 0.95
            location = locator.locate(window, noise=SensorNoise(1e6, 1.0), light='only')
            away = np.array([location.x - x(window.stamp_ns / 1e9), location.y - 30.3])
            squares.append(away @ np.linalg.solve(location.covariance, away) / 2)
    assert found >= 0.97 * lit and partly > 0.2 * found
    # The mean of n halves of a chi-square of two has the deviation 1 / sqrt(n): four of them.
    assert abs(np.mean(squares) - 1.0) < 4.0 / np.sqrt(len(squares))


def test_a_wave_needs_no_name() -> None:
    """The mode periodic with a frequency alone gives its light in every lit frame."""
    frequency = 0.17 * RATE
    scene = before_a_wall(Light(40.2, 30.7, 2.0, 120.0, periodic(frequency, 0.5, 0.1)))
    segmenter = Segmenter(flash=Periodic(frequency=frequency, exposure=EXPOSURE / RATE))
    found = [
        bool(segmenter.sightings(Frame(scene.frame(k), scene.stamp_ns(k), 255)))
        for k in range(90)
    ]
    times = np.arange(90) / RATE
    phase = (times * frequency + 0.1) % 1.0
    lit = (phase > 0.06) & (phase < 0.44)  # for the whole of the exposure, 0.05 of the period
    assert np.array(found)[30:][lit[30:]].all()


def test_codes_and_frequencies_stand_side_by_side() -> None:
    """Each light has its name."""
    scene = before_a_wall(
        Light(*PLACES['port'], 2.0, 120.0, coded(CODES['port'], 1 / RATE, start=0.5 / RATE)),
        Light(*PLACES['starboard'], 2.0, 120.0, periodic(9.3, 0.5)),
    )
    segmenter = Segmenter(flash=flash_by_name(
        'coded', codes={'port': CODES['port']}, frequencies={'starboard': 9.3},
        exposure=EXPOSURE / RATE,
    ))
    seen = set()
    for index in range(60):
        frame = Frame(scene.frame(index), scene.stamp_ns(index), 255)
        for name, window in segmenter.sightings(frame):
            seen.add(name)
            assert abs(window.x0 + (window.lit.shape[1] - 1) / 2 - PLACES[name][0]) <= 1.5
    assert seen == set(PLACES)


@pytest.mark.parametrize('codes, frequencies, sentence', [
    ({}, {}, 'there is no light'),
    ({'a': '1102'}, {}, 'must have zeros and ones'),
    ({'a': '1111'}, {}, 'must have zeros and ones'),
    ({'a b': '110'}, {}, 'a word fit for a topic'),
    ({'a': '1101000', 'b': '1010001'}, {}, 'one code begun at another bit'),
    ({'a': '10', 'b': '0101'}, {}, 'one code begun at another bit'),
    ({'a': '110'}, {'a': 6.0}, 'has a code and a frequency'),
    ({}, {'a': 6.0, 'b': 6.05}, 'clocks are off by 1 %'),
    ({}, {'a': -1.0}, 'must be above 0'),
    ({'a': '10' * 40}, {}, '64 at most'),
])
def test_patterns_that_cannot_work_are_refused(
    codes: dict[str, str], frequencies: dict[str, float], sentence: str
) -> None:
    """With what is wrong about them."""
    with pytest.raises(ValueError, match=sentence):
        check_patterns(codes, frequencies, 0.5)


@pytest.mark.parametrize('frequency, sentence', [
    (35.0, '60.0 frames a second show 1.2 to 27.0 Hz: it looks like 25.0 Hz'),
    (1.0, '60.0 frames a second show 1.2 to 27.0 Hz'),
    (20.0, 'so does a lamp of 100 Hz as 60.0 frames a second show it'),
    (10.0, ''),
])
def test_frequencies_that_the_frames_cannot_show_are_named(
    frequency: float, sentence: str
) -> None:
    """Aliased, or those of a lamp on the mains."""
    fault = rate_fault({'a': frequency}, 60.0)
    assert sentence in fault if sentence else fault == ''


def test_frequencies_that_alias_onto_each_other_are_named() -> None:
    """At 60 frames/s 50 Hz looks like 10 Hz."""
    fault = rate_fault({'a': 10.0, 'b': 50.0}, 60.0)
    assert fault.startswith("'b' flashes at 50 Hz")
    assert fault.endswith("it looks like 10.0 Hz, and so does 'a'")
    assert 'looks like' not in rate_fault({'a': 29.0}, 60.0)
    assert rate_fault({'': 45.0}, 60.0).startswith('the light flashes at 45 Hz; 60.0 frames')


@pytest.mark.parametrize('code, frequency, duty, fault', [
    ('1100', 15.0, 0.5, "the code 1100 of 'a' is a wave of 15 Hz, and 'b' flashes at 15 Hz"),
    ('0110', 15.1, 0.55, 'they cannot be distinguished'),
    ('1100', 15.0, 0.2, ''),
    ('1100', 13.0, 0.5, ''),
    ('1010010', 60.0 / 7.0, 0.5, ''),
])
def test_a_code_that_is_a_wave_is_named(
    code: str, frequency: float, duty: float, fault: str
) -> None:
    """Where there is such a wave beside it."""
    said = twin_fault({'a': code}, 60.0, {'b': frequency}, duty)
    assert said.startswith(fault) or (fault and fault in said)
    assert bool(said) is bool(fault)


@pytest.mark.parametrize('low, high', [(0.6, 1.4), (1.04, 1.05), (0.3, 3.0)])
def test_a_light_that_does_not_keep_its_rate_has_no_wrong_name(low: float, high: float) -> None:
    """Its bits last for 0.6 to 1.4 frames at random, 4 % too long, or for anything."""
    random = np.random.default_rng(4)
    ends = np.cumsum(random.uniform(low, high, 400)) / RATE
    bits = np.tile([float(bit == '1') for bit in CODES['port']], 60)
    scene = before_a_wall(Light(
        *PLACES['port'], 2.0, 120.0, lambda times: bits[np.searchsorted(ends, times)]
    ))
    segmenter = flash(CODES)
    for index in range(200):
        frame = Frame(scene.frame(index), scene.stamp_ns(index), 255)
        found = segmenter.sightings(frame)
        assert {name for name, _ in found} <= {'port'}
        assert found or segmenter.reason


def test_500_points_have_no_name() -> None:
    """A frame with more points than can be looked at says so; no name is given to any."""
    random = np.random.default_rng(1)
    places = random.uniform([6.0, 6.0], [634.0, 474.0], (500, 2))
    scene = Scene(
        elements=[
            Light(x, y, 1.0, 100.0, coded(''.join(random.choice(['0', '1'], 40)), 1.0 / RATE))
            for x, y in places
        ], width=640, height=480, rate=RATE, exposure=EXPOSURE, texture=0.0,
    )
    segmenter = flash(CODES)
    for index in range(25):
        frame = Frame(scene.frame(index), scene.stamp_ns(index), 255)
        assert segmenter.sightings(frame) == []
    assert segmenter.reason.startswith('more than 96 points stand out of the frame')
