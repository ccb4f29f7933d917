"""Parameters that a node declares, and those that it learns of later."""

from __future__ import annotations

from collections.abc import Iterator

from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.parameters import declare, Parameter, undeclared, unknown
import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter as Given

PARAMETERS = (
    Parameter('width', 640, 'Width of the frames.', 16, 8192, unit='px'),
    Parameter('frame_rate', 30.0, 'Frames a second.', 0.0, 1000.0, unit='Hz'),
)


@pytest.fixture
def context(domain: int) -> Iterator[Context]:
    """Give a context of the test's own."""
    context = Context()
    rclpy.init(context=context, domain_id=domain)
    yield context
    rclpy.try_shutdown(context=context)


def node(context: Context, **given: object) -> Node:
    """Return a node that start-up gave these parameters."""
    return Node('node', context=context, parameter_overrides=[
        Given(name, value=value) for name, value in given.items()])


def test_what_is_declared_cannot_be_set_while_running(context: Context) -> None:
    """It was read once: to accept another value would be a lie."""
    running = node(context, width=320)
    assert declare(running, PARAMETERS) == {'width': 320, 'frame_rate': 30.0}
    result = running.set_parameters([Given('width', value=640)])[0]
    assert not result.successful and 'read-only' in result.reason


def test_an_unknown_name_is_an_error_with_a_hint(context: Context) -> None:
    """Unless the node has more than it knows of so far."""
    given = {'width': 320, 'frame_rat': 15.0}
    with pytest.raises(ParameterError, match="'frame_rat'; did you mean 'frame_rate'"):
        declare(node(context, **given), PARAMETERS)
    patient = node(context, **given)
    declare(patient, PARAMETERS, complete=False)
    assert undeclared(patient) == {'frame_rat': 15.0}


def test_a_name_without_a_like_lists_what_there_is() -> None:
    """All names, so that the right one can be found."""
    assert str(unknown('typo', ['gain', 'hue'])) == "no parameter 'typo'; there is gain, hue"
