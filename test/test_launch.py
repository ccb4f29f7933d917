"""The launch file, where `launch` is installed: neither PyPI nor Debian has it."""

from __future__ import annotations

import importlib.util
from pathlib import Path
import py_compile

import pytest

PATH = Path(__file__).parents[1] / 'launch' / 'tracker.launch.py'


def test_launch_file_compiles(tmp_path: Path) -> None:
    """At least its syntax is checked everywhere."""
    py_compile.compile(str(PATH), cfile=str(tmp_path / 'launch.pyc'), doraise=True)


def test_launch_file_describes_three_nodes() -> None:
    """Camera or simulator, segmenter, locator."""
    pytest.importorskip('launch_ros', reason='launch_ros comes with ROS 2 from apt alone')
    spec = importlib.util.spec_from_file_location('tracker_launch', PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    description = module.generate_launch_description()
    nodes = [entity for entity in description.entities if type(entity).__name__ == 'Node']
    assert len(nodes) == 4
