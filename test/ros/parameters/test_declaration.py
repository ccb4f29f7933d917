"""Parameters that a node declares, and those that it learns of later."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.interface import Parameter
from blob_tracker.ros.parameters.declaration import declare, on_change, undeclared
from blob_tracker.ros.parameters.values import unknown
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


def test_a_fixed_one_says_why_it_cannot_change(context: Context) -> None:
    """In its description; to set it is refused."""
    fixed = Parameter('source', 'camera', 'Where frames come from.', fixed='it is made once')
    running = node(context)
    declare(running, [fixed])
    assert 'Read-only: it is made once.' in running.describe_parameter('source').description
    result = running.set_parameters([Given('source', value='images')])[0]
    assert not result.successful and 'read-only' in result.reason


def test_a_change_is_taken_whole_or_not_at_all(context: Context) -> None:
    """Refused with the reason, and the old values stay; what is agreed comes into effect."""
    running = node(context, width=320)
    declare(running, PARAMETERS)
    used: list[dict[str, Any]] = []

    def change(values: dict[str, Any]) -> Callable[[], None]:
        if values['width'] * values['frame_rate'] > 50_000.0:
            raise ParameterError('too many pixels a second')
        return lambda: used.append(values)

    on_change(running, PARAMETERS, change)
    both = [Given('width', value=1600), Given('frame_rate', value=60.0)]
    result = running.set_parameters_atomically(both)
    assert not result.successful and result.reason == 'too many pixels a second'
    assert running.get_parameter('width').value == 320 and not used
    both = [Given('width', value=800), Given('frame_rate', value=60.0)]
    assert running.set_parameters_atomically(both).successful
    assert used == [{'width': 800, 'frame_rate': 60.0}]
    assert not running.set_parameters([Given('width', value=9999)])[0].successful
    assert not running.set_parameters([Given('width', value=15.0)])[0].successful
    assert len(used) == 1


def test_a_choice_is_checked_while_running(context: Context) -> None:
    """As at the start; the reason lists what there is."""
    mode = Parameter('mode', 'a', 'One of two modes.', choices=('a', 'b'))
    running = node(context)
    declare(running, [mode])
    on_change(running, [mode], lambda values: lambda: None)
    result = running.set_parameters([Given('mode', value='c')])[0]
    assert not result.successful and "'mode' is 'c'; it must be one of a, b" in result.reason


def test_an_unknown_name_is_an_error_with_a_hint(context: Context) -> None:
    """Unless the node has more than it knows of so far."""
    given = {'width': 320, 'frame_rat': 15.0}
    with pytest.raises(ParameterError, match="'frame_rat'; did you mean 'frame_rate'"):
        declare(node(context, **given), PARAMETERS)
    assert declare(node(context, **given), PARAMETERS, ['frame_rat'])['width'] == 320
    patient = node(context, **given)
    declare(patient, PARAMETERS, complete=False)
    assert undeclared(patient) == {'frame_rat': 15.0}


def test_a_name_without_a_like_lists_what_there_is() -> None:
    """All names, so that the right one can be found."""
    assert str(unknown('typo', ['gain', 'hue'])) == "no parameter 'typo'; there is gain, hue"
