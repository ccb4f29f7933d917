"""What a command line gives: to whom, and what of it is lost."""

from __future__ import annotations

from pathlib import Path

from blob_tracker.ros.parameters.given import (
    from_files, no_yaml, remarks, Source, sources, unreadable,
)
import pytest


@pytest.mark.parametrize(('key', 'node', 'taken'), [
    ('/**', '/a/b/camera', True),
    ('camera', '/camera', True),
    ('camera', '/left/camera', False),
    ('/**/camera', '/camera', True),
    ('/**/camera', '/a/b/camera', True),
    ('/**/camera', '/a/my_camera', False),
    ('/*/camera', '/left/camera', True),
    ('/*/camera', '/camera', False),
    ('/left/camera', '/left/camera', True),
])
def test_keys(key: str, node: str, taken: bool) -> None:
    """Stars stand for parts of the name, as in rcl."""
    assert Source('', True, key, {}).is_for(node) is taken


def given(folder: Path, content: str, *words: str) -> list[Source]:
    """Return the sources of a command line in which FILE stands for a file of this content."""
    file = folder / 'my.yaml'
    file.write_text(content)
    return list(sources([
        'node', '-p', 'not:=ours', '--ros-args',
        *(each.replace('FILE', str(file)) for each in words), '--', '-p', 'nor:=this',
    ]))


def test_a_file_for_others_is_named(tmp_path: Path) -> None:
    """With those it is for, and with what would be right."""
    content = '/left/camera:\n  ros__parameters: {a: 1}\nright:\n  camera:\n    ros__parameters:\n'
    found = given(tmp_path, content, '--params-file', 'FILE', '-p', 'segmentr:x:=1')
    first, second = remarks(found, {'/camera': {}})
    assert first == (
        f'{tmp_path}/my.yaml holds nothing for /camera: it is keyed to /left/camera, '
        'right/camera; write /**: for any node, or the full name, /camera:'
    )
    assert second == '-p segmentr:x:=1 is for segmentr, and here is /camera: it has no effect'
    assert remarks(found, {'/left/camera': {'a': 1}, '/segmentr': {'x': 1}}) == []


@pytest.mark.parametrize(('words', 'value', 'lost'), [
    (('-p', 'a.b:=9', '--params-file', 'FILE'), 7, True),
    (('--params-file', 'FILE', '-p', 'a.b:=9'), 9, False),
    (('-p', 'q:=1', '--params-file', 'FILE', '-p', 'a.b:=9'), 7, True),
    (('-p', 'a.b:=7', '--params-file', 'FILE'), 7, False),
])
def test_what_loses_to_a_file_is_told(
    tmp_path: Path, words: tuple[str, ...], value: int, lost: bool
) -> None:
    """By what it lost, whichever rcl took."""
    found = given(tmp_path, 'camera:\n  ros__parameters:\n    a: {b: 7}\n', *words)
    said = remarks(found, {'/camera': {'a.b': value, 'q': 1}})
    assert said == ([
        f'-p a.b:=9 is overridden: a.b is 7, by {tmp_path}/my.yaml, under camera; give the file '
        'first and all -p after it'
    ] if lost else [])


def test_a_file_that_cannot_be_read(tmp_path: Path) -> None:
    """The first one is named, with the reason; words that are not ROS' own do not count."""
    there = tmp_path / 'there.yaml'
    there.touch()
    words = ['node', '--ros-args', '--params-file', str(there), '--params-file']
    assert unreadable([*words, str(there)]) == unreadable(['--params-file', 'x.yaml']) == ''
    assert unreadable([*words, 'x.yaml']) == (
        "the parameter file 'x.yaml' cannot be read: No such file or directory"
    )
    assert unreadable([*words, str(tmp_path)]).endswith('Is a directory')


def test_a_file_that_is_no_yaml(tmp_path: Path) -> None:
    """The first one is named, with the line and the reason, where rcl has the line alone."""
    wrong = tmp_path / 'wrong.yaml'
    wrong.write_text('**:\n  ros__parameters: {a: 1}\n')
    right = tmp_path / 'right.yaml'
    right.write_text('/**:\n  ros__parameters: {a: 1}\n')
    words = ['node', '--ros-args', '--params-file', str(right)]
    assert no_yaml(words) == no_yaml([*words, '--params-file', 'x.yaml', '--']) == ''
    assert no_yaml([*words, '--params-file', str(wrong)]).startswith(
        f'{wrong}, line 1, column 2: expected alphabetic or numeric character'
    )


def test_what_files_alone_give(tmp_path: Path) -> None:
    """Not what is given by hand as well."""
    found = given(tmp_path, '/**:\n  ros__parameters: {a: 1, b: 2}\n',
                  '--params-file', 'FILE', '-p', 'b:=3')
    assert from_files(found, '/x') == {'a'}
