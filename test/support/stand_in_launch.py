"""
A stand-in for ROS 2's `launch` and `launch_ros`, which neither PyPI nor Debian has.

It knows what the launch files of this package use, by the names and keywords of Jazzy's sources,
and nothing else: any other name or keyword fails. It records what would be started.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
import importlib.util
from pathlib import Path
import sys
from types import ModuleType
from typing import Any

import pytest


class Substitution:
    """What becomes a text when the arguments are known."""

    def perform(self, context: LaunchContext) -> str:
        """Return the text."""
        raise NotImplementedError


def text(value: Any, context: LaunchContext) -> str:
    """Return the text of a str or a substitution."""
    return value.perform(context) if isinstance(value, Substitution) else value


@dataclass
class LaunchContext:
    """The arguments, and the environment that the launch file sets."""

    launch_configurations: dict[str, str] = field(default_factory=dict)
    environment: dict[str, str] = field(default_factory=dict)


@dataclass
class LaunchConfiguration(Substitution):
    variable_name: str

    def perform(self, context: LaunchContext) -> str:
        return context.launch_configurations[self.variable_name]


@dataclass
class FindPackageShare(Substitution):
    package: str

    def perform(self, context: LaunchContext) -> str:
        return f'/share/{self.package}'


@dataclass
class PathJoinSubstitution(Substitution):
    substitutions: list[Any]

    def perform(self, context: LaunchContext) -> str:
        return '/'.join(text(part, context) for part in self.substitutions)


@dataclass
class EnvironmentVariable(Substitution):
    name: str
    default_value: Any = field(default=None, kw_only=True)

    def perform(self, context: LaunchContext) -> str:
        return context.environment.get(self.name) or text(self.default_value, context)


@dataclass
class DeclareLaunchArgument:
    name: str
    default_value: Any = field(default=None, kw_only=True)
    description: str = field(kw_only=True)
    choices: list[str] | None = field(default=None, kw_only=True)


@dataclass
class SetEnvironmentVariable:
    name: str
    value: Any


@dataclass
class OpaqueFunction:
    function: Callable[[LaunchContext], list[Any]] = field(kw_only=True)


@dataclass(eq=False)
class ExecuteProcess:
    cmd: list[Any] = field(kw_only=True)
    output: str = field(kw_only=True, default='log')


@dataclass(eq=False)
class Node:
    executable: str = field(kw_only=True)
    package: str = field(kw_only=True)
    namespace: str = field(kw_only=True, default='')
    parameters: list[Any] = field(kw_only=True, default_factory=list)
    arguments: list[Any] = field(kw_only=True, default_factory=list)
    ros_arguments: list[Any] = field(kw_only=True, default_factory=list)
    output: str = field(kw_only=True, default='log')


@dataclass
class OnProcessExit:
    target_action: ExecuteProcess = field(kw_only=True)
    on_exit: Callable[[ProcessExited, LaunchContext], Any] = field(kw_only=True)


@dataclass
class RegisterEventHandler:
    event_handler: OnProcessExit


@dataclass
class TimerAction:
    period: float = field(kw_only=True)
    actions: list[Any] = field(kw_only=True)


@dataclass
class Shutdown:
    pass


@dataclass
class ProcessExited:
    returncode: int


@dataclass
class LaunchDescription:
    entities: list[Any]


class LaunchDescriptionEntity:
    """Named in annotations alone."""


MODULES = {
    'launch': (LaunchContext, LaunchDescription, LaunchDescriptionEntity),
    'launch.actions': (
        DeclareLaunchArgument, ExecuteProcess, OpaqueFunction, RegisterEventHandler,
        SetEnvironmentVariable, Shutdown, TimerAction,
    ),
    'launch.event_handlers': (OnProcessExit,),
    'launch.events': (),
    'launch.events.process': (ProcessExited,),
    'launch.substitutions': (EnvironmentVariable, LaunchConfiguration, PathJoinSubstitution),
    'launch_ros': (),
    'launch_ros.actions': (Node,),
    'launch_ros.substitutions': (FindPackageShare,),
}


def started(
    path: Path, monkeypatch: pytest.MonkeyPatch, context: LaunchContext, **given: str
) -> list[Any]:
    """Read a launch file and return what it starts with these arguments."""
    for name, members in MODULES.items():
        module = ModuleType(name)
        for member in members:
            setattr(module, member.__name__, member)
        monkeypatch.setitem(sys.modules, name, module)
    spec = importlib.util.spec_from_file_location('launch_file', path)
    file = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(file)
    actions: list[Any] = []
    unknown = set(given)
    for entity in file.generate_launch_description().entities:
        if isinstance(entity, DeclareLaunchArgument):
            unknown.discard(entity.name)
            value = given.get(entity.name, entity.default_value)
            assert value is not None, f'{entity.name} must be given'
            value = text(value, context)
            assert entity.choices is None or value in entity.choices
            context.launch_configurations[entity.name] = value
        elif isinstance(entity, SetEnvironmentVariable):
            context.environment[entity.name] = text(entity.value, context)
        else:
            assert isinstance(entity, OpaqueFunction)
            actions += entity.function(context)
    assert not unknown, f'no such argument: {unknown}'
    return actions
