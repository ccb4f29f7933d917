"""The examples in docstrings do what they say, and each name on the pages of the API has one."""

from __future__ import annotations

from collections.abc import Iterator
import doctest
from importlib import import_module
from inspect import isclass, isfunction
from pathlib import Path
import re

import blob_tracker
import pytest

PACKAGE = Path(blob_tracker.__file__).parent
MODULES = sorted(
    '.'.join(path.relative_to(PACKAGE.parent).with_suffix('').parts)
    for path in PACKAGE.rglob('*.py') if '\n    >>> ' in path.read_text()
)
PAGES = sorted((Path(__file__).parents[1] / 'doc' / 'api').glob('*.rst'))
DIRECTIVE = re.compile(r'^\.\. auto(module|class):: (\S+)((?:\n   :.*)*)', re.M)
# They return nothing, and compile for longer than all the examples run.
WITHOUT = {'compile_ahead', 'compile_lens'}
# They need a camera; their examples are shown and not run.
NOT_RUN = {'ControlError', 'Grabber', 'NoFrameError', 'V4l2Camera'}


def on_the_pages() -> Iterator[tuple[str, object]]:
    """Yield the classes and functions that Sphinx puts on the pages of the API."""
    for page in PAGES:
        for kind, path, options in DIRECTIVE.findall(page.read_text()):
            if kind == 'class':
                module, _, name = path.rpartition('.')
                yield name, getattr(import_module(module), name)
                continue
            module = import_module(path)
            left_out = re.findall(r':exclude-members: (.+)', options)
            for name in getattr(module, '__all__', vars(module)):
                value = getattr(module, name)
                own = hasattr(module, '__all__') or getattr(value, '__module__', '') == path
                if own and (isclass(value) or isfunction(value)) and not name.startswith('_') \
                        and name not in ', '.join(left_out).split(', '):
                    yield name, value


def examples(name: str, value: object) -> list[doctest.Example]:
    """Return the examples of a class and its methods, or of a function."""
    return [each for test in doctest.DocTestFinder().find(value, name) for each in test.examples]


@pytest.mark.parametrize('module', MODULES)
def test_examples_hold(module: str) -> None:
    """Each is run as it stands."""
    assert doctest.testmod(import_module(module)).failed == 0


def test_each_name_on_the_pages_has_an_example() -> None:
    """One that runs, but for those whose reason stands above."""
    public = [(name, examples(name, value)) for name, value in on_the_pages()]
    assert {name for name, found in public} >= set(blob_tracker.__all__)
    assert {name for name, found in public if not found} == WITHOUT
    skipped = {
        name for name, found in public if any(doctest.SKIP in each.options for each in found)
    }
    assert skipped == NOT_RUN
