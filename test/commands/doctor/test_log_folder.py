"""A log folder that cannot be written, or has little room."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.commands.doctor import log_folder
from blob_tracker.commands.doctor.finding import Level
from support.findings import told

MIB = 2**20


def test_log_folder(tmp_path: Path) -> None:
    """Where it is, one that cannot be made, and a full disk."""
    told(log_folder.check_log_folder({'ROS_LOG_DIR': '/proc/logs'}), Level.WARN, '/proc/logs',
         'without log files', 'export ROS_LOG_DIR=')
    (tmp_path / 'file').touch()
    told(log_folder.check_log_folder({'ROS_LOG_DIR': str(tmp_path / 'file')}), Level.WARN)
    assert log_folder.log_folder({'ROS_HOME': '/r', 'HOME': '/h'}) == Path('/r/log')
    assert log_folder.log_folder({'HOME': '/h'}) == Path('/h/.ros/log')
    told([log_folder.judge_room(tmp_path, 5 * MIB)], Level.WARN, '5 MiB', 'make room', 'du -sh')
    told([log_folder.judge_room(tmp_path, 2**30)], Level.OK, '1.0 GiB')
