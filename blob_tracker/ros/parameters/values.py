"""Values of parameters: what may be one, and what is said of one that may not. No ROS."""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from typing import Any

from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.interface import Parameter

NULLS = ('null', 'Null', 'NULL', '~')


@contextmanager
def about(name: str) -> Iterator[None]:
    """Raise what is wrong with a value as a ParameterError that names the parameter."""
    try:
        yield
    except (OSError, ValueError) as error:
        raise ParameterError(f"parameter '{name}': {error}") from None


def check(parameter: Parameter, value: Any) -> None:
    """Raise ParameterError if a parameter may not have a value, as a node refuses it."""
    check_given(parameter, value)
    allowed = type(value) is type(parameter.default)
    if allowed and parameter.choices:
        allowed = value in parameter.choices
    elif allowed and parameter.least is not None and parameter.most is not None:
        allowed = parameter.least <= value <= parameter.most
    if not allowed:
        raise not_allowed(parameter, value)


def check_given(parameter: Parameter, value: Any) -> None:
    """Raise ParameterError if start-up gave no value: rcl takes null of YAML for a text."""
    if value is None or (isinstance(parameter.default, str) and value in NULLS):
        given = '[] or empty' if value is None else value
        raise ParameterError(
            f"parameter '{parameter.name}' is {given}, which is not a value; it must be "
            f'{parameter.allowed}; leave it out for its default, {parameter.value}'
        )


def unknown(name: str, names: Iterable[str]) -> ParameterError:
    """Return the error for the name of a parameter that is none of these."""
    names = list(names)
    near = get_close_matches(name, names, n=1)
    hint = f"did you mean '{near[0]}'?" if near else f'there is {", ".join(names)}'
    return ParameterError(f"no parameter '{name}'; {hint}")


def not_allowed(parameter: Parameter, value: Any) -> ParameterError:
    """Return the error for a value that a parameter may not have."""
    hint = ''
    if type(value) is int and isinstance(parameter.default, float):
        hint = f'; write {value}.0'
    elif type(value) is float and type(parameter.default) is int and value.is_integer():
        hint = f'; write {value:.0f}'
    elif isinstance(parameter.default, str) and isinstance(value, (list, tuple, array)):
        words = ','.join(value) if all(isinstance(each, str) for each in value) else '...'
        hint = f"; it is one text and no list: {parameter.name}: '{words:.200}'"
    elif isinstance(parameter.default, str) and not isinstance(value, str):
        hint = (
            '; put it in quotes, for without them 0110 is the number 72, 1e5 is one as well, and '
            f"on, off, yes, no, y and n are true or false: {parameter.name}: '...' in a file, "
            f'or -p "{parameter.name}:=\'...\'" in a shell'
        )
    return ParameterError(
        f"parameter '{parameter.name}' is {value!r:.200}; it must be {parameter.allowed}{hint}"
    )
