"""Several lights are told apart by their bits, with wrong bits among them."""

from __future__ import annotations

from blob_tracker.segmentation import Segmenter
from blob_tracker.segmentation.coded import check_codes, Coded
from blob_tracker.simulation import coded, Light, periodic, Scene
from blob_tracker.types import Frame
import pytest

# Neither is a shift of the other.
CODES = {'port': '1101000', 'starboard': '1111010'}
RATE = 60.0
PLACES = {'port': (40.2, 30.7), 'starboard': (110.6, 80.1), 'red': (40.2, 30.7)}


def before_a_wall(*lights: Light) -> Scene:
    """Return a scene of these lights."""
    return Scene(
        elements=lights, width=160, height=120, rate=RATE, exposure=0.3, texture=0.0
    )


def lights(codes: dict[str, str], frames_per_bit: int = 1) -> Scene:
    """Return one light for each code."""
    time = frames_per_bit / RATE
    return before_a_wall(*(
        # Bits change between the exposures of the one light, within them for the other.
        Light(*PLACES[name], 2.0, 120.0, coded(bits, time, start=(0.5 + 0.8 * index) / RATE))
        for index, (name, bits) in enumerate(codes.items())
    ))


def flash(codes: dict[str, str], frames_per_bit: int = 1, bit_errors: int = 0) -> Segmenter:
    """Return a segmenter for the codes."""
    return Segmenter(flash=Coded(
        max_pair_interval=0.1,
        codes=codes,
        frames_per_bit=frames_per_bit,
        bit_errors=bit_errors,
    ))


def names(segmenter: Segmenter, scene: Scene, count: int) -> dict[str, int]:
    """Feed frames; return how often each light was given, each time at its place."""
    found: dict[str, int] = {}
    for index in range(count):
        frame = Frame(scene.frame(index), scene.stamp_ns(index), 255)
        for name, window in segmenter.sightings(frame):
            height, width = window.lit.shape
            x, y = PLACES[name]
            assert abs(window.x0 + (width - 1) / 2 - x) <= 1.5
            assert abs(window.y0 + (height - 1) / 2 - y) <= 1.5
            assert window.lit.max() > window.unlit.max() + 50
            found[name] = found.get(name, 0) + 1
    return found


@pytest.mark.parametrize('frames_per_bit', [1, 3])
def test_each_light_is_named_at_every_rise(frames_per_bit: int) -> None:
    """After one length of the code; a code with two rises gives two windows a round."""
    turn = 7 * frames_per_bit
    found = names(flash(CODES, frames_per_bit), lights(CODES, frames_per_bit), 6 * turn)
    # The first round and the one in which a light first rose are needed to read the bits.
    for name, rises in (('port', 2), ('starboard', 2)):
        assert 4 * rises <= found[name] <= 5 * rises


def test_wrong_bits_are_tolerated_up_to_their_number() -> None:
    """A frame in which the light fails, once a round: named with one wrong bit allowed."""
    code = '111101011001000'
    scene = lights({'red': code})
    off = before_a_wall()
    for bit_errors, seen in ((1, True), (0, False)):
        segmenter = flash({'red': code}, bit_errors=bit_errors)
        found = 0
        for index in range(75):
            # The second of four ones is dark: two runs of ones, where there should be one.
            missing = index % 15 == 1
            image = (off if missing else scene).frame(index)
            found += len(segmenter.sightings(Frame(image, scene.stamp_ns(index), 255)))
        assert (found > 0) is seen


def test_other_blinking_is_no_light() -> None:
    """Neither a mains-like flicker nor a light that is switched on once has a code."""
    scene = before_a_wall(
        Light(40.2, 30.7, 2.0, 120.0, periodic(0.31 * RATE, 0.5)),
        Light(110.6, 80.1, 2.0, 120.0, lambda times: (times > 0.3).astype(float)),
    )
    segmenter = flash(CODES)
    assert names(segmenter, scene, 60) == {}
    assert 'places blink' in segmenter.reason or 'no code' in segmenter.reason


def test_a_gap_in_the_frames_starts_reading_afresh() -> None:
    """No name until a whole code was seen again."""
    scene, segmenter = lights(CODES), flash(CODES)
    assert names(segmenter, scene, 30)
    for index in range(60, 66):
        frame = Frame(scene.frame(index), scene.stamp_ns(index), 255)
        assert segmenter.sightings(frame) == []


@pytest.mark.parametrize('codes, bit_errors, sentence', [
    ({}, 0, 'there is no code'),
    ({'a': '1102'}, 0, 'must have zeros and ones'),
    ({'a': '1111'}, 0, 'must have zeros and ones'),
    ({'a b': '110'}, 0, 'a word fit for a topic'),
    ({'a': '110', 'b': '1100'}, 0, 'differ in length'),
    ({'a': '1101000', 'b': '1010001'}, 0, 'differ by 0 bits'),
    (CODES, 1, 'it must be 3'),
])
def test_codes_that_cannot_work_are_refused(
    codes: dict[str, str], bit_errors: int, sentence: str
) -> None:
    """With what is wrong about them."""
    with pytest.raises(ValueError, match=sentence):
        check_codes(codes, bit_errors)


def test_bits_are_read_in_any_phase() -> None:
    """A start in the middle of the code is read as well as one at its beginning."""
    scene = lights(CODES)
    for first in range(1, 7):
        segmenter = flash(CODES)
        seen = set()
        for index in range(first, first + 40):
            frame = Frame(scene.frame(index), scene.stamp_ns(index), 255)
            seen |= {name for name, _ in segmenter.sightings(frame)}
        assert seen == set(CODES)


def test_a_code_that_is_too_long_is_refused() -> None:
    """Every phase of it is compared: memory grows with the square."""
    with pytest.raises(ValueError, match='a code of 20000 frames is too long'):
        Coded(codes={'a': '10' * 5000}, frames_per_bit=2)
