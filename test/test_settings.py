"""The settings of the tools agree with each other."""

from __future__ import annotations

from configparser import ConfigParser
from pathlib import Path

import ament_flake8

ROOT = Path(__file__).parents[1]


def test_plain_flake8_is_as_that_of_ros() -> None:
    """What an editor shows is what ament_flake8 finds."""
    ours, theirs = ConfigParser(), ConfigParser()
    ours.read(ROOT / '.flake8')
    theirs.read(Path(ament_flake8.__file__).parent / 'configuration' / 'ament_flake8.ini')
    settings = dict(ours['flake8'])
    del settings['exclude']  # ament_flake8 is told where to look
    assert settings == dict(theirs['flake8'])
