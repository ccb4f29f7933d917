"""
What a node shows of itself, as data: its parameters, topics and services.

One declaration of each is read by the node, by its `--help`, by config/tracker.yaml, by its page
in docs/nodes and by config/security/policy.xml.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

_TYPES = {bool: 'a boolean', int: 'an integer', float: 'a number with a point', str: 'a string'}
_LISTS = {float: 'a list of numbers with a point', str: 'a list of strings'}
MOST_CHOICES, SOME_CHOICES = 12, 6  # of more than the first, a table names the second


@dataclass(frozen=True)
class Parameter:
    """
    One parameter.

    Parameters
    ----------
    name : str
        Its name; dots part groups.
    default : bool, int, float, str or list
        Gives the type as well; a list is one of strings or of floats, and not empty, for rcl takes
        an empty one for no value.
    description : str
        What it does and why one would change it.
    least, most : int or float, optional
        Range of a number.
    choices : sequence of str
        The values a string may have; empty leaves it free.
    unit : str
        Unit of a number.
    fixed : str
        Why it cannot change while the node runs; empty if it can.

    """

    name: str
    default: bool | int | float | str | list[str] | list[float]
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
        if isinstance(self.default, list):
            return f'{_LISTS[type(self.default[0])]}, as {self.value}'
        words = _TYPES[type(self.default)]
        if self.least is not None and self.most is not None:
            words += f' from {_number(self.least)} to {_number(self.most)}'
        return f'{words} {self.unit}'.strip()

    @property
    def limits(self) -> str:
        """Say the same for a table, as short as it can be; empty for any text."""
        if len(self.choices) > MOST_CHOICES:
            named = [choice for choice in self.choices if choice]
            return f'{", ".join(named[:SOME_CHOICES])} ... {len(named)} in all'
        if self.choices:
            return ', '.join(self.choices)
        if isinstance(self.default, bool):
            return 'true, false'
        if isinstance(self.default, list):
            return _LISTS[type(self.default[0])].removeprefix('a ')
        if self.least is not None and self.most is not None:
            return f'{_number(self.least)} to {_number(self.most)} {self.unit}'.strip()
        return self.unit

    @property
    def value(self) -> str:
        """Return the default as YAML and `ros2 param set` have it."""
        if isinstance(self.default, bool):
            return str(self.default).lower()
        if isinstance(self.default, list):
            return f'[{",".join(map(str, self.default))}]'
        return str(self.default) or "''"


@dataclass(frozen=True)
class Topic:
    """
    One topic.

    Parameters
    ----------
    name : str
        As the node gives it: relative, from / or from ~/, which stands for the node's name.
    kind : str
        Package and message, as sensor_msgs/Image.
    description : str
        What it carries, with units.

    """

    name: str
    kind: str
    description: str


@dataclass(frozen=True)
class Service:
    """
    One service; its fields are those of a topic.

    Parameters
    ----------
    name, kind, description : str
        See `Topic`.

    """

    name: str
    kind: str
    description: str


@dataclass(frozen=True)
class Interface:
    """
    All that a node shows.

    Parameters
    ----------
    node : str
        Its name, and that of its executable.
    caption : str
        What it is about, in a few words.
    summary : str
        What it does.
    parameters : sequence of Parameter
        What can be set.
    subscribed, published : sequence of Topic
        What it reads and what it says.
    services : sequence of Service
        What it does when asked.
    each_light : sequence of Topic
        Those that each coded light has under its name as well, target/<name>/... for target/...
    examples : sequence of str
        Command lines.

    """

    node: str
    caption: str
    summary: str
    parameters: Sequence[Parameter]
    subscribed: Sequence[Topic] = ()
    published: Sequence[Topic] = ()
    services: Sequence[Service] = ()
    each_light: Sequence[Topic] = ()
    examples: Sequence[str] = ()

    @property
    def sections(self) -> list[tuple[str, Sequence[Topic] | Sequence[Service]]]:
        """Topics and services, each kind that there is with its title."""
        return [
            (title, entries) for title, entries in (
                ('Subscribes to', self.subscribed), ('Publishes', self.published),
                ('Services', self.services),
            ) if entries
        ]

    def resolved(self, name: str) -> str:
        """Return the name of a topic without ~: relative, or from /."""
        return name.replace('~', self.node, 1) if name.startswith('~/') else name


def _number(value: float) -> str:
    """Return a bound as one would write it."""
    return str(value) if isinstance(value, int) else f'{value:.10g}'
