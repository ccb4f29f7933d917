"""What may be the value of a parameter, and what is said of one that may not."""

from __future__ import annotations

from array import array
import datetime
from typing import Any

from blob_tracker.ros.errors import ParameterError
from blob_tracker.ros.interface import Parameter
from blob_tracker.ros.parameters.values import check
import pytest

TEXT = Parameter('lights', '', 'Names of lights.')
NUMBER = Parameter('gain', 1.0, 'Gain of the camera.', 0.5, 100.0)
COUNT = Parameter('width', 100, 'Of a frame.', 1, 1000)


@pytest.mark.parametrize(('parameter', 'value', 'sentence'), [
    (TEXT, None, r"'lights' is \[\] or empty, which is not a value; .* its default, ''"),
    (TEXT, 'null', "'lights' is null, which is not a value"),
    (TEXT, '~', 'which is not a value'),
    (NUMBER, None, r'\[\] or empty, which is not a value; it must be a number .*its default, 1.0'),
    (TEXT, 72, "is 72; it must be a string; put it in quotes, .*: lights: '...' in a file"),
    (TEXT, 1e5, 'put it in quotes'),
    (TEXT, False, 'on, off, yes, no, y and n are true or false'),
    (TEXT, datetime.date(2024, 1, 1), "or -p \"lights:='...'\" in a shell"),
    (TEXT, ['left', 'right'], "one text and no list: lights: 'left,right'$"),
    (TEXT, array('q', [1, 0]), r"no list: lights: '\.\.\.'$"),
    (NUMBER, 3, '; write 3.0$'),
    (COUNT, 640.0, '; write 640$'),
    (COUNT, 640.5, 'it must be an integer from 1 to 1000$'),
    (NUMBER, True, 'is True; it must be a number with a point from 0.5 to 100$'),
])
def test_what_is_refused(parameter: Parameter, value: Any, sentence: str) -> None:
    """With what would be right."""
    with pytest.raises(ParameterError, match=sentence):
        check(parameter, value)


@pytest.mark.parametrize(('parameter', 'value'), [
    (TEXT, ''), (TEXT, 'on,no'), (TEXT, '2024-01-01'), (NUMBER, 2.0),
])
def test_what_is_taken(parameter: Parameter, value: Any) -> None:
    """A text is a text, whatever it looks like."""
    check(parameter, value)
