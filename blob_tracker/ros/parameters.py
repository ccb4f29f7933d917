"""Parameters of a node: one declaration gives type, range, unit and reason."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from blob_tracker.ros.errors import ParameterError
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node

_TYPES = {bool: 'a boolean', int: 'an integer', float: 'a number with a point', str: 'a string'}


@dataclass(frozen=True)
class Parameter:
    """
    One parameter.

    Parameters
    ----------
    name : str
        Its name; dots part groups.
    default : bool, int, float or str
        Gives the type as well.
    description : str
        What it does and why one would change it.
    least, most : int or float, optional
        Range of a number.
    choices : sequence of str
        The values a string may have; empty leaves it free.
    unit : str
        Unit of a number.

    """

    name: str
    default: bool | int | float | str
    description: str
    least: float | None = None
    most: float | None = None
    choices: Sequence[str] = ()
    unit: str = ''

    @property
    def allowed(self) -> str:
        """Say in words what the value must be."""
        if self.choices:
            return 'one of ' + ', '.join(choice or "''" for choice in self.choices)
        words = _TYPES[type(self.default)]
        if self.least is not None:
            words += f' from {self.least:g} to {self.most:g}'
        return f'{words} {self.unit}'.strip()

    def descriptor(self) -> ParameterDescriptor:
        """Return what `ros2 param describe` shows."""
        text = f'{self.description} Must be {self.allowed}.'
        descriptor = ParameterDescriptor(name=self.name, description=text, read_only=True)
        if self.least is None or self.most is None:
            return descriptor
        if isinstance(self.default, float):
            bounds = FloatingPointRange(from_value=float(self.least), to_value=float(self.most))
            descriptor.floating_point_range = [bounds]
        else:
            whole = IntegerRange(from_value=int(self.least), to_value=int(self.most), step=1)
            descriptor.integer_range = [whole]
        return descriptor


def declare(
    node: Node, parameters: Sequence[Parameter], complete: bool = True
) -> dict[str, Any]:
    """
    Declare parameters on a node and return their values; they are read-only from then on.

    Parameters
    ----------
    node : Node
        The node.
    parameters : sequence of Parameter
        What it has.
    complete : bool
        Whether it has no others; False where their names are known later: see `undeclared`.

    Returns
    -------
    dict
        Value by name.

    Raises
    ------
    ParameterError
        Where a value that was given at start-up has the wrong type or lies outside its range, or
        nothing has the name of one.

    """
    values = {}
    for parameter in parameters:
        try:
            value = node.declare_parameter(
                parameter.name, parameter.default, parameter.descriptor()
            ).value
        except (InvalidParameterTypeException, InvalidParameterValueException):
            raise _refused(node, parameter) from None
        if parameter.choices and value not in parameter.choices:
            raise _refused(node, parameter)
        values[parameter.name] = value
    if complete:
        for name in undeclared(node):
            raise unknown(name, values)
    return values


def undeclared(node: Node) -> dict[str, Any]:
    """Return the values that start-up gave to parameters that the node does not have so far."""
    # What rclpy was told at start-up is not public; nothing else knows of a misspelt name.
    return {
        name: parameter.value
        for name, parameter in node._parameter_overrides.items()
        if not node.has_parameter(name) and not name.startswith('qos_overrides.')
    }


def unknown(name: str, names: Iterable[str]) -> ParameterError:
    """Return the error for the name of a parameter that is none of these."""
    names = list(names)
    near = get_close_matches(name, names, n=1)
    hint = f"did you mean '{near[0]}'?" if near else f'there is {", ".join(names)}'
    return ParameterError(f"no parameter '{name}'; {hint}")


def _refused(node: Node, parameter: Parameter) -> ParameterError:
    """Return the error for the value that start-up gave to a parameter."""
    given = node._parameter_overrides[parameter.name].value
    hint = ''
    if isinstance(given, int) and isinstance(parameter.default, float):
        hint = f'; write {given}.0'
    return ParameterError(
        f"parameter '{parameter.name}' is {given!r}; it must be {parameter.allowed}{hint}"
    )
