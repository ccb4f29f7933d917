"""
tf2_msgs for where no ROS is installed: no registry of Python has it.

It is made as ROS makes it, by rosidl's generators and the C compiler, of its one line.
"""

from __future__ import annotations

from contextlib import suppress
from importlib.metadata import version
from importlib.util import find_spec
import json
import os
from pathlib import Path
import shutil
import subprocess
import sys
import sysconfig
import tempfile

import numpy
import pytest

ROOT = Path(__file__).parents[2]
NAME = 'tf2_msgs'
TEXT = 'geometry_msgs/TransformStamped[] transforms\n'  # geometry2, tf2_msgs/msg/TFMessage.msg
# rosidl's generators, the class of each, and what it makes.
GENERATORS = {
    'rosidl_generator_c': 'GenerateC',
    'rosidl_generator_py': 'GeneratePython',
    'rosidl_typesupport_c': 'GenerateCTypesupport',
    'rosidl_typesupport_fastrtps_c': 'GenerateFastRTPSCTypesupport',
    'rosidl_typesupport_introspection_c': 'GenerateIntrospectionCTypesupport',
}
# What rmw_fastrtps takes: the one to write and read a message, the other to describe its type.
# Each is looked for by the name of its library.
SUPPORTS = ['rosidl_typesupport_fastrtps_c', 'rosidl_typesupport_introspection_c']
COMPILERS = {'.c': ('gcc', '-std=gnu11'), '.cpp': ('g++', '-std=c++17')}
# Of which each library takes functions.
NEEDED = (
    *(f'geometry_msgs__{part}' for part in GENERATORS), 'rosidl_runtime_c', 'rcutils',
    'rosidl_typesupport_c', *SUPPORTS, 'rosidl_typesupport_fastrtps_cpp', 'fastcdr',
)
GENERATE = """
import importlib, json, pathlib, sys
from rosidl_cli.command.translate.api import translate
folder, name, share, generators, supports = json.loads(sys.argv[1])
folder = pathlib.Path(folder)
idl = list(translate(
    package_name=name, interface_files=[f'{folder}:msg/TFMessage.msg'], include_paths=[share],
    output_format='idl', output_path=folder,
))
options = {
    'rosidl_typesupport_c': {'typesupport_implementations': supports},
    'rosidl_generator_py': {'typesupport_implementations': ['rosidl_typesupport_c']},
}
for module, kind in generators.items():
    made = getattr(importlib.import_module(module + '.cli'), kind)
    made(module, **options.get(module, {})).generate(name, idl, [share], folder / module / name)
"""


def provide_tf2_messages() -> None:
    """Have tf2_msgs importable, here and in the processes that are started; else skip or fail."""
    if find_spec(NAME) is not None:
        return
    missing = [name for name in GENERATORS if find_spec(name) is None]
    headers = Path(sysconfig.get_path('include')) / 'Python.h'
    missing += [] if headers.is_file() else [str(headers)]
    missing += [compiler for compiler, _ in COMPILERS.values() if shutil.which(compiler) is None]
    if missing:
        reason = f'tf2_msgs is not installed, nor {", ".join(missing)}, which would make it'
        if 'CI' in os.environ:
            pytest.fail(reason)
        pytest.skip(reason)
    tags = sys.implementation.cache_tag, *(
        version(f'ros-{name.replace("_", "-")}') for name in (*GENERATORS, 'geometry_msgs')
    )
    folder = ROOT / '.cache' / NAME / '-'.join(map(str, tags))
    if not folder.exists():
        folder.parent.mkdir(parents=True, exist_ok=True)
        made = Path(tempfile.mkdtemp(dir=folder.parent))
        _make(made)
        with suppress(OSError):  # another run was faster
            made.rename(folder)
        shutil.rmtree(made, ignore_errors=True)
    sys.path.append(str(folder))
    paths = [os.environ.get('PYTHONPATH', ''), str(folder)]
    os.environ['PYTHONPATH'] = os.pathsep.join(filter(None, paths))


def _make(folder: Path) -> None:
    """Make the package in a folder."""
    (folder / 'msg').mkdir()
    (folder / 'msg' / 'TFMessage.msg').write_text(TEXT)
    prefix = Path(sys.prefix)
    words = json.dumps([str(folder), NAME, str(prefix / 'share'), GENERATORS, SUPPORTS])
    _run(
        sys.executable, '-c', GENERATE, words,
        environment=os.environ | {'AMENT_PREFIX_PATH': str(prefix)},
    )
    package = folder / 'rosidl_generator_py' / NAME
    (package / '__init__.py').touch()
    includes = [prefix / 'include', *(prefix / 'include').iterdir()]
    includes += [folder / part for part in GENERATORS]
    options = [f'-I{each}' for each in (
        *includes, sysconfig.get_path('include'), numpy.get_include()
    )]
    libraries = [f'-l{name}' for name in NEEDED]
    for part in ('rosidl_generator_c', *SUPPORTS):
        own = f'{NAME}__{part}'
        _link(package / f'lib{own}.so', _compiled(folder / part, options), libraries)
        libraries.append(f'-l{own}')
    objects = _compiled(package, options) + _compiled(folder / 'rosidl_typesupport_c', options)
    _link(package / f'{NAME}_s__rosidl_typesupport_c.so', objects, libraries)
    package.rename(folder / NAME)
    for part in ('msg', *GENERATORS):
        shutil.rmtree(folder / part)


def _compiled(folder: Path, options: list[str]) -> list[Path]:
    """Return the objects of all sources in a folder."""
    objects = []
    for source in (path for end in COMPILERS for path in folder.rglob(f'*{end}')):
        objects.append(source.with_suffix('.o'))
        compiler = COMPILERS[source.suffix]
        _run(*compiler, '-O1', '-fPIC', *options, '-c', str(source), '-o', str(objects[-1]))
    return objects


def _link(library: Path, objects: list[Path], libraries: list[str]) -> None:
    """Make a library that finds those of ROS, and those beside it."""
    of_ros = Path(sys.prefix) / 'lib'
    _run(
        'g++', '-shared', f'-Wl,-soname,{library.name}', '-Wl,--no-as-needed',
        f'-Wl,-rpath,$ORIGIN:{of_ros}', f'-L{library.parent}', f'-L{of_ros}',
        *map(str, objects), *libraries, '-o', str(library),
    )


def _run(*command: str, environment: dict[str, str] | None = None) -> None:
    """Run a command; what it says is in the error where it fails."""
    result = subprocess.run(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    if result.returncode:
        raise RuntimeError(f'{" ".join(command):.2000}\n{result.stdout}')
