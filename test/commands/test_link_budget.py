"""`optics --led`: a link budget from the command line."""

from __future__ import annotations

import argparse
from pathlib import Path
import re

from blob_tracker.__main__ import main
from blob_tracker.commands import optics
from blob_tracker.commands.link_budget import asked, CAMERA, fitted, watts
from blob_tracker.radiometry.budget import LEAST_SNR
import pytest


def test_powers() -> None:
    """With a unit or none."""
    assert [watts(text) for text in ('3W', '500mW', '1.5kW', '3')] == [3.0, 0.5, 1500.0, 3.0]


def test_a_light_in_the_sun(capsys: pytest.CaptureFixture[str]) -> None:
    """Electrons, SNR and mrad; that daylight saturates it, and what exposure fits."""
    assert main(['optics', '--led', '3W', '--range', '1000']) == 0
    text = ' '.join(capsys.readouterr().out.split())
    assert 'the background alone saturates the pixels' in text
    assert 'exposure that fits' in text and 'nothing is clipped' in text
    full, fitting = text.split('nothing is clipped')
    assert full.count('none: pixels are full') == 4 and 'Cramer-Rao bound │ inf' not in text
    assert 'none: pixels are full' not in fitting
    for column in ('sun', 'overcast', 'dusk', 'night'):
        assert column in text


def test_with_a_filter_it_is_found(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """Options are in the units of their help; the picture is drawn."""
    words = 'optics --led 3W --range 1000 --filter 10 --exposure 1 --visibility 23 --pixel 3.45'
    picture = tmp_path / 'budget.png'
    assert main([*words.split(), '--plot', str(picture)]) == 0
    text = capsys.readouterr().out
    assert 'At 1000 m: found' in text and 'nothing is clipped' not in text
    assert picture.stat().st_size > 10_000


@pytest.mark.parametrize(
    'words, sentence',
    [
        (['--range', '0'], 'the range, m, is 0; it must be above 0'),
        (['--visibility', '0'], 'the visibility, km, is 0'),
        (['--efficiency', '2'], 'the efficiency is 2'),
        (['--focal-length', '8', '16'], '--led takes one --focal-length'),
        (
            ['--plot', '/no/such/folder/budget.png'],
            '--plot /no/such/folder/budget.png: No such file or directory',
        ),
        (['--plot', '/tmp/budget.docx'], '--plot /tmp/budget.docx: '),
    ],
)
def test_impossible_numbers(
    words: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """One sentence, and the exit code of wrong use."""
    assert main(['optics', '--led', '3W', *words]) == 2
    assert sentence in capsys.readouterr().err


def test_options_without_a_light_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    """None is taken and does nothing; without any the lens table is as ever."""
    words = 'optics --filter 10 --exposure 2 --sky --light dusk --plot budget.png'
    assert main(words.split()) == 2
    said = '--filter, --exposure, --sky, --light, --plot: of a light, which --led gives'
    assert said in capsys.readouterr().err
    assert main(['optics', '--focal-length', '6']) == 0


def test_the_page_says_what_is_printed() -> None:
    """Each row of the table in docs/limits.md, to its last digit."""
    page = (Path(__file__).parents[2] / 'docs' / 'limits.md').read_text()
    rows = re.findall(
        r'^\| .+ \| `(.+)` \| ([\d.,]+) \| ([\d.]+|-) \|$',
        page.partition('<!-- budgets -->')[2].partition('<!-- end -->')[0], re.M,
    )
    assert len(rows) == 10
    parser = argparse.ArgumentParser()
    optics.add_arguments(parser)
    for options, snr, bound in rows:
        arguments = parser.parse_args(options.split())
        length = (arguments.focal_length or [CAMERA.focal_length])[0]
        led, camera, around = asked(arguments, length, CAMERA.pixel)
        budget = fitted(led, camera, around, arguments.range)
        digits = len(snr.partition('.')[2])
        assert round(budget.snr, digits) == float(snr.replace(',', '')), options
        if bound == '-':
            assert budget.snr < LEAST_SNR, options
        else:
            digits = len(bound.partition('.')[2])
            assert round(budget.bound_mrad, digits) == float(bound), options
