"""What ROS sees of the package once colcon has built it."""

from __future__ import annotations

import ast
from email.message import Message
from email.parser import Parser
from importlib.metadata import metadata
import os
from pathlib import Path
import re
import shutil
import subprocess
import sys
from typing import Any
from zipfile import ZipFile

from ament_index_python.packages import get_package_share_directory, get_packages_with_prefixes
import blob_tracker
from blob_tracker.commands.doctor.python import OPTIONAL, REQUIRED
from blob_tracker.nodes import NODES
from catkin_pkg.package import parse_package
from support.processes import executable
import yaml

ROOT = Path(__file__).parents[1]
# Keys of rosdistro (rosdep/python.yaml and jazzy/distribution.yaml) with what they install on
# Ubuntu 24.04; looked up by hand when a key is added.
KNOWN_KEYS = yaml.safe_load((Path(__file__).parent / 'rosdep_keys.yaml').read_text())
# What the package imports, by the key that installs it.
KEYS = {
    # rosbags brings apsw, zstd and lz4.
    **dict.fromkeys(('apsw', 'backports', 'lz4', 'rosbags'), 'python3-rosbags-pip'),
    'cv2': 'python3-opencv',
    'matplotlib': 'python3-matplotlib',
    'numba': 'python3-numba',
    'numpy': 'python3-numpy',
    'rich': 'python3-rich',
    'scipy': 'python3-scipy',
    'yaml': 'python3-yaml',
}
# What is imported only where it is asked for, by the extra of setup.py that brings it: rosdep has
# no key for these.
EXTRAS = {'astropy': 'files', 'distributed': 'cluster', 'tifffile': 'files'}
# What pip calls the others that it has.
WHEELS = {
    **dict.fromkeys(('apsw', 'backports', 'lz4'), 'rosbags'), 'cv2': 'opencv-python-headless',
    'yaml': 'PyYAML',
}


def in_setup(name: str) -> Any:
    """Return a constant of setup.py."""
    for node in ast.parse((ROOT / 'setup.py').read_text()).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == name:
            return ast.literal_eval(node.value)
    raise AssertionError(f'setup.py has no {name}')


def names(requirements: list[str]) -> set[str]:
    """Return the names of requirements, without their versions."""
    return {re.split(r'[=<>;\[]', each)[0].strip() for each in requirements}


def pinned(file: str) -> set[str]:
    """Return the names in a file of pinned requirements."""
    lines = (ROOT / file).read_text().splitlines()
    return names([line for line in lines if line and line[0] not in '#-'])


def test_package_xml_is_format_3_with_keys_that_exist() -> None:
    """It parses without a warning, and rosdep knows each key for Jazzy."""
    warnings: list[str] = []
    package = parse_package(str(ROOT), warnings=warnings)
    assert not warnings
    assert package.package_format == 3
    assert package.get_build_type() == 'ament_python'
    assert [str(text) for text in package.licenses] == ['Apache-2.0']
    keys = {d.name for d in package.build_depends + package.exec_depends + package.test_depends}
    assert keys <= set(KNOWN_KEYS)


def test_every_import_is_declared() -> None:
    """What the package imports is in package.xml, to be installed wherever it runs."""
    package = parse_package(str(ROOT))
    declared = {d.name for d in package.exec_depends}
    used = set()
    for path in Path(blob_tracker.__file__).parent.rglob('*.py'):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                used |= {alias.name.split('.')[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                used.add(str(node.module).split('.')[0])
    foreign = used - set(sys.stdlib_module_names) - {'blob_tracker'} - set(EXTRAS)
    assert {KEYS.get(name, name) for name in foreign} <= declared
    extras = in_setup('EXTRAS')
    assert all(name in names(extras[extra]) for name, extra in EXTRAS.items())


def test_pip_rosdep_and_doctor_know_the_same_libraries() -> None:
    """What setup.py tells pip is what package.xml tells rosdep, pinned, and no more."""
    dependencies = names(in_setup('DEPENDENCIES'))
    assert dependencies == {WHEELS.get(name, name) for name in KEYS}
    assert dependencies == {wheel for wheel, *_ in (REQUIRED | OPTIONAL).values()}
    assert dependencies <= pinned('requirements.txt')
    extras = in_setup('EXTRAS')
    assert {name for each in extras.values() for name in names(each)} <= pinned(
        'requirements/test.txt'
    )


def test_a_wheel_is_whole(tmp_path: Path) -> None:
    """It has the configuration, asks for the libraries, and has one command, `blob_tracker`."""
    ours = shutil.ignore_patterns('.*', '__pycache__', 'test', 'build', 'install', 'log', 'out')
    source = tmp_path / 'source'
    shutil.copytree(ROOT, source, ignore=ours)
    subprocess.run(
        [sys.executable, '-W', 'ignore', 'setup.py', '--quiet', 'bdist_wheel', '-d', tmp_path],
        cwd=source, check=True, capture_output=True,
    )
    wheel, = tmp_path.glob('*.whl')
    with ZipFile(wheel) as archive:
        inside = archive.namelist()
        info = next(each for each in inside if each.endswith('.dist-info/METADATA'))
        described: Message = Parser().parsestr(archive.read(info).decode())
        commands = archive.read(info.replace('METADATA', 'entry_points.txt')).decode()
    assert {'blob_tracker/config/tracker.yaml', 'blob_tracker/pipeline.py'} <= set(inside)
    assert commands.split() == ['[console_scripts]', 'blob_tracker', '=',
                                'blob_tracker.__main__:main']
    asked = [each for each in described.get_all('Requires-Dist') if 'extra ==' not in each]
    assert names(asked) == names(in_setup('DEPENDENCIES'))
    assert set(described.get_all('Provides-Extra')) == set(in_setup('EXTRAS'))


def test_the_version_is_that_of_the_changelog_and_of_the_citation() -> None:
    """The newest one of the changelog, whose other versions are older, each with its date."""
    lines = (ROOT / 'CHANGELOG.rst').read_text()
    found = re.findall(r'^(\d+)\.(\d+)\.(\d+) \((\d{4}-\d\d-\d\d)\)\n-+$', lines, re.M)
    versions = [(tuple(map(int, numbers)), date) for *numbers, date in found]
    assert len(versions) >= 2 and versions == sorted(versions, reverse=True)
    citation = yaml.safe_load((ROOT / 'CITATION.cff').read_text())
    newest = '.'.join(map(str, versions[0][0]))
    assert parse_package(str(ROOT)).version == citation['version'] == newest
    assert str(citation['date-released']) == versions[0][1]
    assert f"version='{newest}'" in (ROOT / 'setup.py').read_text()


def test_the_licence_is_apache_and_no_library_is_under_the_gpl() -> None:
    """By its text, by package.xml, and by what each library says of itself."""
    package = parse_package(str(ROOT))
    text = (ROOT / str(package.licenses[0].file)).read_text()
    assert text.split()[:4] == ['Apache', 'License', 'Version', '2.0,']
    assert 'END OF TERMS AND CONDITIONS' in text
    assert yaml.safe_load((ROOT / 'CITATION.cff').read_text())['license'] == 'Apache-2.0'
    for name in names(in_setup('DEPENDENCIES')):
        told = metadata(name)
        said = [*told.get_all('License-Expression', []), *told.get_all('Classifier', [])]
        said += [each.partition('\n')[0] for each in told.get_all('License', [])]
        assert any(said) and not any(re.search(r'\bA?GPL|GNU', each) for each in said), name


def test_the_site_is_what_rosdoc2_looks_for() -> None:
    """The file that package.xml names, with the two parts and the folder that it wants."""
    exported, = [each for each in parse_package(str(ROOT)).exports if each.tagname == 'rosdoc2']
    kind, settings = yaml.safe_load_all((ROOT / exported.content).read_text())
    assert kind == {'type': 'rosdoc2 config', 'version': 1}
    assert settings['settings']['never_run_sphinx_apidoc']
    builder, = settings['builders']
    assert (ROOT / builder['sphinx']['sphinx_sourcedir'] / 'conf.py').is_file()


def test_colcon_sees_an_ament_python_package() -> None:
    """A package.xml with a fault would silently become plain Python."""
    result = subprocess.run(
        ['colcon', '--log-base', os.devnull, 'list', '--paths', str(ROOT)],
        capture_output=True,
        text=True,
    )
    assert '(ros.ament_python)' in result.stdout, result.stdout + result.stderr


def test_installed_files_are_where_ros_looks() -> None:
    """Executables in lib/blob_tracker, the ament index entry, config and launch in share."""
    for name in NODES:
        assert os.access(executable(name), os.X_OK)
    assert 'blob_tracker' in get_packages_with_prefixes()
    share = Path(get_package_share_directory('blob_tracker'))
    for name in (
        'package.xml',
        'config/tracker.yaml',
        'config/blob_tracker.rviz',
        'examples/servo_client.py',
        'launch/tracker.launch.py',
    ):
        assert (share / name).is_file()
