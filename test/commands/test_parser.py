"""What is misspelt is said, with what it should be, and with the usage of its own command."""

from __future__ import annotations

from blob_tracker.__main__ import main
import pytest


@pytest.mark.parametrize('words, usage, said', [
    ('track light --flash.freqency 8', 'track', 'did you mean --flash.frequency?'),
    ('track light --flash.freqency=8', 'track', 'did you mean --flash.frequency?'),
    ('track light --qqqq', 'track', 'arguments: --qqqq; --help lists the options'),
    ('track light dark', 'track', 'unrecognized arguments: dark\n'),
    ('calibrate noise light --max-frame 9 --fieldz', 'calibrate noise', '--max-frame'),
    ('optics --focal-lenght 8', 'optics', 'did you mean --focal-length?'),
    ('optics --range 1km', 'optics', "argument --range: '1km' is not a number; write 12.5 say"),
    ('optics --width 640.5', 'optics', "argument --width: '640.5' is not a whole number"),
    ('optics --led 3X', 'optics', "argument --led: '3X' is not a power; write 3W, 500mW or"),
    ('track light --frame-rate sixty', 'track', "'sixty' is not a number above 0; write 60 say"),
    ('calibrate line_time f --frequency 50Hz', 'calibrate line_time', "'50Hz' is not a number"),
])
def test_a_word_that_is_wrong(
    words: str, usage: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 2, the command's usage, and what to write."""
    with pytest.raises(SystemExit) as ended:
        main(words.split())
    assert ended.value.code == 2
    told = capsys.readouterr().err
    assert told.startswith(f'usage: python3 -m blob_tracker {usage} [')
    assert said in told
