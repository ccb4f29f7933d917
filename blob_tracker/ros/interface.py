"""What a node shows of itself: one declaration gives type, range, unit and reason."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

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
    fixed : str
        Why it cannot change while the node runs; empty where it can.

    """

    name: str
    default: bool | int | float | str
    description: str
    least: float | None = None
    most: float | None = None
    choices: Sequence[str] = ()
    unit: str = ''
    fixed: str = ''

    @property
    def allowed(self) -> str:
        """Say in words what the value must be."""
        if self.choices:
            return 'one of ' + ', '.join(choice or "''" for choice in self.choices)
        words = _TYPES[type(self.default)]
        if self.least is not None and self.most is not None:
            words += f' from {_number(self.least)} to {_number(self.most)}'
        return f'{words} {self.unit}'.strip()


def _number(value: float) -> str:
    """Return a bound as one would write it."""
    return str(value) if isinstance(value, int) else f'{value:g}'
