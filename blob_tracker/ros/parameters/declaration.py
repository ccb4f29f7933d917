"""Parameters of a node: declared, and changed while it runs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import Any

from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.interface import Parameter
from blob_tracker.ros.parameters.values import check_given, not_allowed, unknown
from rcl_interfaces.msg import (
    FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult,
)
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter as Given


def declare(
    node: Node,
    parameters: Sequence[Parameter],
    elsewhere: Collection[str] = (),
    *,
    complete: bool = True,
) -> dict[str, Any]:
    """
    Declare parameters on a node and return their values.

    Parameters
    ----------
    node : Node
        The node.
    parameters : sequence of Parameter
        What it has.
    elsewhere : collection of str
        Names that start-up may give to it and that are other nodes' of the same process.
    complete : bool
        Whether it has no others; False where their names are known later: see `undeclared`.

    Returns
    -------
    dict
        Value by name.

    Raises
    ------
    ParameterError
        If a value that was given at start-up has the wrong type or lies outside its range, or
        nothing has the name of one.

    """
    values = {}
    for parameter in parameters:
        if parameter.name in node._parameter_overrides:
            check_given(parameter, node._parameter_overrides[parameter.name].value)
        try:
            value = node.declare_parameter(
                parameter.name, parameter.default, _descriptor(parameter)
            ).value
        except (InvalidParameterTypeException, InvalidParameterValueException):
            raise _rejected(node, parameter) from None
        if parameter.choices and value not in parameter.choices:
            raise _rejected(node, parameter)
        values[parameter.name] = value
    if complete:
        for name in undeclared(node, elsewhere):
            raise unknown(name, values)
    return values


def on_change(
    node: Node,
    parameters: Sequence[Parameter],
    change: Callable[[dict[str, Any]], Callable[[], None]],
) -> None:
    """
    Let declared parameters change while the node runs, together or not at all.

    Parameters
    ----------
    node : Node
        The node. A callback that acts by itself, on a device say, has to be added before.
    parameters : sequence of Parameter
        Those of `declare`.
    change : callable
        Takes all values as they would be, and returns what puts them into effect; that is called
        once they are set. A ParameterError of it refuses them, and all stays as it was.

    """
    declared = {parameter.name: parameter for parameter in parameters}
    agreed: list[Callable[[], None]] = []

    def check(asked: list[Given]) -> SetParametersResult:
        ours = {each.name: each.value for each in asked if each.name in declared}
        if not ours:
            return SetParametersResult(successful=True)
        agreed.clear()
        values = {name: node.get_parameter(name).value for name in declared} | ours
        try:
            for name, value in ours.items():
                if declared[name].choices and value not in declared[name].choices:
                    raise not_allowed(declared[name], value)
            agreed.append(change(values))
        except ParameterError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def carry_out(asked: list[Given]) -> None:
        words = [f'{g.name} is {g.value!r:.80}' for g in asked if g.name in declared]
        if words and agreed:
            agreed.pop()()
            node.get_logger().info(f'changed: {", ".join(words)}')

    node.add_on_set_parameters_callback(check)
    node.add_post_set_parameters_callback(carry_out)


def undeclared(node: Node, elsewhere: Collection[str] = ()) -> dict[str, Any]:
    """Return the values that start-up gave to parameters that nothing here has so far."""
    return {
        name: value
        for name, value in given(node).items()
        if not node.has_parameter(name) and name not in elsewhere
    }


def given(node: Node) -> dict[str, Any]:
    """Return the values that start-up gave to a node's parameters, QoS overrides left out."""
    # What rclpy was told at start-up is not public; nothing else knows of a misspelt name.
    return {
        name: parameter.value
        for name, parameter in node._parameter_overrides.items()
        if not name.startswith('qos_overrides.')
    }


def _descriptor(parameter: Parameter) -> ParameterDescriptor:
    """Return what `ros2 param describe` shows."""
    text = f'{parameter.description} Must be {parameter.allowed}.'
    if parameter.fixed:
        text += f' Read-only: {parameter.fixed}.'
    descriptor = ParameterDescriptor(
        name=parameter.name, description=text, read_only=bool(parameter.fixed)
    )
    least, most = parameter.least, parameter.most
    if least is None or most is None:
        return descriptor
    if isinstance(parameter.default, float):
        bounds = FloatingPointRange(from_value=float(least), to_value=float(most))
        descriptor.floating_point_range = [bounds]
    else:
        whole = IntegerRange(from_value=int(least), to_value=int(most), step=1)
        descriptor.integer_range = [whole]
    return descriptor


def _rejected(node: Node, parameter: Parameter) -> ParameterError:
    """Return the error for the value that start-up gave to a parameter."""
    return not_allowed(parameter, node._parameter_overrides[parameter.name].value)
