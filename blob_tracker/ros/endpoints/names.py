"""Names of topics that depend on a light."""

from __future__ import annotations

import re

from blob_tracker.ros.errors import ParameterError

# A token of a topic's name (https://design.ros2.org/articles/topic_and_service_names.html), short
# enough that no name gets longer than DDS takes it.
NAME = re.compile(r'[A-Za-z](_?[A-Za-z0-9]){0,63}')


def target_topic(light: str) -> str:
    """Return what the names of a light's topics begin with; the only light has no name."""
    return f'target/{light}' if light else 'target'


def lights_from_text(text: str, parameter: str = 'lights') -> list[str]:
    """
    Return the names of lights in a parameter; if it is empty, the one of none.

    Raises
    ------
    ParameterError
        If one of them is invalid.

    """
    lights = text.replace(' ', '').split(',')  # [''] if it is empty
    if text:
        for light in lights:
            try:
                check_light(light)
            except ParameterError as error:
                raise ParameterError(
                    f"parameter '{parameter}': {error}; write port,starboard"
                ) from None
    return lights


def check_light(name: str) -> None:
    """Raise ParameterError if a light cannot have this name."""
    if not NAME.fullmatch(name):
        raise ParameterError(
            f'{name!r:.60} is not a name for a light; it is a part of topics: a letter, then up '
            'to 63 more or digits, with single underscores between them'
        )
