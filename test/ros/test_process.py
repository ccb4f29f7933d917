"""Nodes of one process: what their start pays for, so that a frame need not."""

from __future__ import annotations

import inspect
import sys

from blob_tracker.ros.process import know_who_logs
import pytest
import rclpy.impl.rcutils_logger as logger


def test_a_line_that_is_logged_resolves_no_files(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a module that is loaded by then; rclpy asks for the frames of its own and of the node."""
    def refuse(*asked: object) -> None:
        raise AssertionError('a file is resolved')

    know_who_logs()
    monkeypatch.setattr(inspect, 'getabsfile', refuse)
    assert logger.CallerId().function_name == 'test_a_line_that_is_logged_resolves_no_files'
    assert inspect.getmodule(sys._getframe(), __file__) is sys.modules[__name__]
