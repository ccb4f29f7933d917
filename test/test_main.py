"""The command line: help, and wrong words."""

from __future__ import annotations

import os
import subprocess
import sys

from blob_tracker.__main__ import COMMANDS, main
import pytest

PRINTS = """\
import sys
from types import SimpleNamespace
from blob_tracker import __main__ as commands

commands.command = lambda name: SimpleNamespace(
    add_arguments=lambda parser: None, main=lambda parsed: print('a line') or 0
)
sys.exit(commands.main(['echo']))
"""


def test_help_names_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    """--help ends well and lists them."""
    with pytest.raises(SystemExit) as ended:
        main(['--help'])
    assert ended.value.code == 0
    text = capsys.readouterr().out
    assert all(name in text for name in COMMANDS)


@pytest.mark.parametrize('name', COMMANDS)
def test_each_command_has_help(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Its own options are listed."""
    with pytest.raises(SystemExit) as ended:
        main([name, '--help'])
    assert ended.value.code == 0
    assert 'usage: python3 -m blob_tracker' in capsys.readouterr().out


@pytest.mark.parametrize('words', [[], ['fly']])
def test_wrong_words_are_wrong_use(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """No command, or one that does not exist: exit code 2 and the usage."""
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2
    assert 'usage: ' in capsys.readouterr().err


def test_output_that_nobody_reads_leaves_no_trace() -> None:
    """As where it is piped into `head`."""
    reading, writing = os.pipe()
    os.close(reading)
    for command in (['-m', 'blob_tracker', 'optics'], ['-c', PRINTS]):  # by rich, and by print
        ended = subprocess.run(
            [sys.executable, *command], stdout=writing, stderr=subprocess.PIPE, text=True
        )
        assert (ended.returncode, ended.stderr) == (1, '')
    os.close(writing)
