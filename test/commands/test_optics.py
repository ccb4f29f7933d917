"""Table 2.1 of the thesis to the last digit, and the same for any lens."""

from __future__ import annotations

from blob_tracker.__main__ import main
from blob_tracker.studies.chapters_2_to_4.lens_table import computed, printed
import pytest


def test_table_2_1_digit_for_digit() -> None:
    """Every value that is printed, and eight rows of them."""
    rows = printed()
    assert list(rows) == [1.8, 3.5, 6.0, 10.0, 12.5, 16.0, 25.0, 100.0]
    assert {length: computed(length) for length in rows} == rows


def test_sensor_of_the_text_is_not_that_of_the_table() -> None:
    """On 7.95 mm no field of view is that printed."""
    assert all(computed(length, 7.95)[1] != row[1] for length, row in printed().items())


def test_table_is_printed_with_its_comparison(capsys: pytest.CaptureFixture[str]) -> None:
    """Without options: the thesis' table, all of it as printed."""
    assert main(['optics']) == 0
    text = ' '.join(capsys.readouterr().out.split())
    assert 'Table 2.1 of the thesis' in text
    assert '16 of 16 values are those printed' in text
    assert '6.41 mm wide' in text


def test_own_lens(capsys: pytest.CaptureFixture[str]) -> None:
    """Numbers worked out by hand: f = 8 / 0.00345 px, and 0.03 px of them at 300 m."""
    words = 'optics --focal-length 8 --pixel 3.45 --width 1440 --height 1080 --resolution 0.03'
    assert main([*words.split(), '--range', '300']) == 0
    text = capsys.readouterr().out
    assert 'Table 2.1' not in text
    for number in (
        '2318.8',  # px
        '34.50 x 26.22',  # 2 atan(4.968 / 16), 2 atan(3.726 / 16)
        '0.431',  # atan(1 / 2318.8), mrad
        '0.0129',  # 0.03 / 2318.8
        '0.0118',  # times the squared cosine of 17.25 degrees
        '0.00388',  # m at 300 m
        '14.4',  # 0.2 / sqrt(3) / 8
    ):
        assert number in text, number


@pytest.mark.parametrize(
    'words, sentence',
    [
        (['--focal-length', '-3'], 'the focal length is -3 mm; it must be above 0'),
        (['--focal-length', 'nan'], 'the focal length is nan mm'),
        (['--pixel', '0'], 'the pixel size is 0 um'),
        (['--width', '0'], '0 x 489 px; it must be positive'),
        (['--range', '0'], '--range is 0; it must be above 0'),
        (['--resolution', 'inf'], '--resolution is inf'),
        (['--centre-tolerance', '-1'], 'centre_tolerance_mm is -1; it must be 0 or more'),
    ],
)
def test_impossible_numbers(
    words: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """One sentence, and the exit code of wrong use."""
    assert main(['optics', *words]) == 2
    assert sentence in capsys.readouterr().err
