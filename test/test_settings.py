"""What is written in two files is the same in both."""

from __future__ import annotations

from configparser import ConfigParser
from pathlib import Path
import re
from xml.etree import ElementTree

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


def test_the_version_is_the_same_everywhere() -> None:
    """For ROS in package.xml, for Python in setup.py."""
    in_setup = re.findall(r"version='([^']+)'", (ROOT / 'setup.py').read_text())
    assert in_setup == [ElementTree.parse(ROOT / 'package.xml').findtext('version')]
