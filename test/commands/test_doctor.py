"""The doctor finds what is wrong: each check on a place or an environment made wrong for it."""

from __future__ import annotations

from collections.abc import Iterable
import errno
import fcntl
import json
import os
from pathlib import Path
import subprocess
import sys
from typing import Any

import blob_tracker
from blob_tracker.capture import CaptureError, videodev2
from blob_tracker.capture.fields import FieldStream
from blob_tracker.capture.topology import Sensor
from blob_tracker.commands.doctor import cameras, compiled, discovery, examined, installation
from blob_tracker.commands.doctor import log_folder, profile, python, security, shared_memory
from blob_tracker.commands.doctor.finding import error, Finding, Level, ok, warn
from blob_tracker.commands.doctor.report import as_json, Report, summary
from blob_tracker.commands.doctor.self_test import free_domain, judge, Run
from blob_tracker.nodes import NODES
from blob_tracker.resources import config_path
from blob_tracker.types import Frame
import numpy as np
import pytest
import rclpy
from support.slowness import slowness

DOCTOR = [sys.executable, '-m', 'blob_tracker', 'doctor']
MIB = 2**20


def one(findings: Iterable[Finding]) -> Finding:
    """Return the only finding."""
    (finding,) = findings
    return finding


def told(findings: Iterable[Finding], level: Level, *words: str) -> None:
    """Assert that there is one finding, how bad it is, and what is in it."""
    finding = one(findings)
    everything = f'{finding.message} {finding.advice} {finding.command}'
    assert finding.level is level, everything
    for word in words:
        assert word in everything
    # Whoever is told that something is wrong is told what to do.
    assert level is Level.OK or finding.advice or finding.command or ';' in finding.message


# Python and the libraries


def test_python_that_the_wheels_are_not_made_for() -> None:
    """3.10 to 3.13."""
    told(python.check_python((3, 9)), Level.ERROR, '3.9', 'runs on 3.10 to 3.13')
    told(python.check_python((3, 14)), Level.ERROR, '3.14')
    told(python.check_python((3, 10)), Level.OK, '3.10')


def test_libraries_that_are_missing_or_broken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that is required is an error; a broken one says why."""
    (tmp_path / 'broken_library.py').write_text("raise ImportError('numpy 9 is too new')")
    monkeypatch.syspath_prepend(tmp_path)
    told(python.check_libraries({'no_such_library': ('no-such', 'python3-no-such')}, {}),
         Level.ERROR, 'no_such_library is not installed', 'install ')
    told(python.check_libraries({'broken_library': ('broken', 'python3-broken')}, {}),
         Level.ERROR, 'cannot be imported: ImportError: numpy 9 is too new')
    told(python.check_libraries({}, {'no_such_library': ('no-such', '', 'bags')}),
         Level.WARN, 'bags need it', 'pip install no-such')
    told(python.check_libraries(), Level.OK, 'numpy ', 'opencv-python-headless ', 'rosbags ')


# ROS


def fake_rclpy(prefix: Path, source: str) -> Path:
    """Make a package rclpy where apt would have put it."""
    package = prefix / 'lib' / 'python3.12' / 'site-packages' / 'rclpy'
    package.mkdir(parents=True)
    (package / '__init__.py').write_text(source)
    (package / 'node.py').touch()
    return package / '__init__.py'


def test_no_ros_at_all(tmp_path: Path) -> None:
    """The core is said to work, and the way to ROS depends on what the machine has."""
    told(installation.check_ros({}, None, [], tmp_path), Level.ERROR,
         'no node can run', 'Pipeline', 'pip install')
    (tmp_path / 'humble').mkdir()
    (tmp_path / 'humble' / 'setup.bash').touch()
    told(installation.check_ros({}, None, [], tmp_path), Level.ERROR, 'has humble')
    (tmp_path / 'jazzy').mkdir()
    (tmp_path / 'jazzy' / 'setup.bash').touch()
    told(installation.check_ros({}, None, [], tmp_path), Level.ERROR,
         f'source {tmp_path}/jazzy/setup.bash')


def test_the_wrong_ros(tmp_path: Path) -> None:
    """Another distribution, one for another Python, and two at once."""
    rclpy = fake_rclpy(tmp_path, '')
    told(installation.check_ros({'ROS_DISTRO': 'humble'}, rclpy, []), Level.ERROR,
         'ROS_DISTRO is humble', '/jazzy/setup.bash')
    told(installation.check_ros({'ROS_DISTRO': 'jazzy'}, rclpy, []), Level.OK, 'jazzy')
    rclpy.write_text("raise ImportError('built for 3.12')")
    told(installation.check_ros({'ROS_DISTRO': 'jazzy'}, rclpy, []), Level.ERROR,
         'cannot load it: ImportError: built for 3.12')


def test_the_wrong_wheels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A wheel of another distribution; a wheel, and another ROS sourced."""
    monkeypatch.setattr(sys, 'prefix', str(tmp_path))
    rclpy = fake_rclpy(tmp_path, '')
    told(installation.check_ros({}, rclpy, ['ros-kilted-rclpy']), Level.ERROR,
         'ros-kilted-rclpy is installed', 'jazzy is needed')
    told(installation.check_ros({}, rclpy, ['ros-jazzy-rclpy']), Level.OK, 'wheels')
    told(installation.check_ros({'ROS_DISTRO': 'jazzy'}, rclpy, ['ros-jazzy-rclpy']), Level.WARN,
         'there are two')


def test_middleware(tmp_path: Path) -> None:
    """The default, another one that is there, and one that is not."""
    rclpy = fake_rclpy(tmp_path, '')
    folders = installation.library_folders({'LD_LIBRARY_PATH': 'relative:/no/such'}, rclpy)
    assert folders == [tmp_path / 'lib']
    told(installation.check_rmw({}, folders), Level.ERROR, 'there is none', 'apt install')
    for name in ('rmw_fastrtps_cpp', 'rmw_fastrtps_shared_cpp', 'rmw_cyclonedds_cpp'):
        (tmp_path / 'lib' / f'lib{name}.so').touch()
    found = one(installation.check_rmw({}, folders))
    assert found == ok('RMW', 'rmw_fastrtps_cpp (installed: rmw_cyclonedds_cpp, rmw_fastrtps_cpp)')
    told(installation.check_rmw({'RMW_IMPLEMENTATION': 'rmw_cyclonedds_cpp'}, folders),
         Level.WARN, 'export RMW_IMPLEMENTATION=rmw_fastrtps_cpp')
    told(installation.check_rmw({'RMW_IMPLEMENTATION': 'rmw_zenoh_cpp'}, folders), Level.ERROR,
         'rmw_zenoh_cpp', 'not installed', 'unset RMW_IMPLEMENTATION')


def test_messages_of_tf(tmp_path: Path) -> None:
    """There; to be installed where ROS is; and not to be had where it is not."""
    told(installation.check_tf({}, tmp_path / 'tf2_msgs' / '__init__.py'), Level.OK, 'work')
    told(installation.check_tf({'ROS_DISTRO': 'jazzy'}, None), Level.WARN,
         'sudo apt install ros-jazzy-tf2-msgs')
    told(installation.check_tf({}, None), Level.OK, 'leave use_tf and publish_tf false')


def test_package(tmp_path: Path) -> None:
    """Not installed, without executables, older than what is imported, and well."""
    imported = tmp_path / 'checkout' / 'blob_tracker'
    imported.mkdir(parents=True)
    (imported / 'types.py').write_text('new')
    told(installation.check_package({}, imported), Level.WARN, '`ros2 run`', 'colcon build')

    prefix = tmp_path / 'install'
    marker = prefix / 'share/ament_index/resource_index/packages/blob_tracker'
    marker.parent.mkdir(parents=True)
    marker.touch()
    environment = {'AMENT_PREFIX_PATH': f'/elsewhere{os.pathsep}{prefix}'}
    told(installation.check_package(environment, imported), Level.ERROR, 'has no camera, ')

    folder = prefix / 'lib' / 'blob_tracker'
    folder.mkdir(parents=True)
    for name in NODES:
        (folder / name).touch(mode=0o755)
    installed = prefix / 'lib' / 'python3.12' / 'site-packages' / 'blob_tracker'
    installed.mkdir(parents=True)
    (installed / 'types.py').write_text('old')
    told(installation.check_package(environment, imported), Level.WARN, 'imports another one')
    (installed / 'types.py').write_text('new')
    told(installation.check_package(environment, imported), Level.OK, str(prefix))


# The kernels


def test_kernels() -> None:
    """One of those that the defaults need is not compiled; and a Numba that is switched off."""
    all_needed = {name: (2, 2, '/c') for name in compiled.NEEDED}
    rooms = {'location': (3, 5, '/c'), 'segmentation': (1, 1, '/c'), 'tracking': (2, 2, '/c')}
    told([compiled.judge({**rooms, **all_needed})], Level.OK, 'location 3 of 5')
    told([compiled.judge({**rooms, **all_needed, 'location.contract': (1, 2, '/c')})], Level.WARN,
         'location 3 of 5', 'need (location.contract)', sys.executable, 'compile_ahead()')
    told(compiled.check_compiled({'NUMBA_DISABLE_JIT': '1'}, None), Level.ERROR, 'unset')
    # The build compiles them ahead.
    told(compiled.check_compiled(os.environ, Path('/')), Level.OK, 'location', '__pycache__')


def test_kernels_that_cannot_be_loaded(tmp_path: Path) -> None:
    """Numba's refusal to keep its code has an advice of its own."""
    package = tmp_path / 'blob_tracker'
    package.mkdir()
    path = {**os.environ, 'PYTHONPATH': str(tmp_path)}
    (package / '__init__.py').write_text("raise RuntimeError('no locator available for file x')")
    told(compiled.check_compiled(path, tmp_path), Level.ERROR, 'export NUMBA_CACHE_DIR=')
    (package / '__init__.py').write_text("raise ImportError('no numba')")
    told(compiled.check_compiled(path, tmp_path), Level.ERROR, 'ImportError: no numba')


# Shared memory


def test_shared_memory_that_is_not_there(tmp_path: Path) -> None:
    """No folder; one that is there is measured."""
    told(shared_memory.check_shared_memory(tmp_path / 'shm'), Level.ERROR, 'there is no ', 'mount')
    (tmp_path / 'shm').mkdir()
    space, left = shared_memory.check_shared_memory(tmp_path / 'shm')
    assert 'MiB are free' in space.message
    assert left == ok('shared memory', 'no segments of dead processes, 0 of living ones')


@pytest.mark.parametrize(
    'size, free, level, words',
    [
        (64, 64, Level.WARN, '--shm-size=1g'),  # as Docker comes
        (64, 30, Level.ERROR, '--shm-size=1g'),
        (200, 130, Level.WARN, 'too little for 5'),
        (1000, 30, Level.ERROR, 'ls -lS'),
        (1000, 500, Level.OK, '500 of 1000 MiB'),
    ],
)
def test_room_in_shared_memory(size: int, free: int, level: Level, words: str) -> None:
    """Four processes with their segments of 35 MiB have to fit."""
    told([shared_memory.judge_space(Path('/s'), size * MIB, free * MIB)], level, words)


def test_segments_of_the_dead(tmp_path: Path) -> None:
    """A lock that nobody holds; locks of ports and files of others do not count."""
    for name in ('fastrtps_0123456789abcdef', 'fastrtps_fedcba9876543210'):
        (tmp_path / name).write_bytes(bytes(2 * MIB))
        (tmp_path / f'{name}_el').touch()
    (tmp_path / 'fastrtps_port7411_el').touch()
    (tmp_path / 'lttng-ust-wait').touch()
    with open(tmp_path / 'fastrtps_fedcba9876543210_el') as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        alive, dead, size = shared_memory.leftovers(tmp_path)
        assert (alive, dead, size // MIB) == (1, 1, 2)
    told([shared_memory.judge_leftovers(tmp_path, alive, dead, size)], Level.WARN,
         '1 segments of dead processes hold 2 MiB', 'fastdds shm clean')
    assert shared_memory.leftovers(tmp_path)[:2] == (0, 2)


def test_nodes_of_other_users(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each once, by the locks of their segments; one's own, ports and other files do not count."""
    for name in ('fastrtps_0123456789abcdef_el', 'fastrtps_port7411_el', 'lttng-ust-wait'):
        (tmp_path / name).touch()
    assert shared_memory.other_users(tmp_path) == []
    assert list(shared_memory.judge_users([], 1000)) == []
    own = os.geteuid()
    monkeypatch.setattr(os, 'geteuid', lambda: own + 1)
    assert shared_memory.other_users(tmp_path) == [own]
    told(shared_memory.judge_users([1001, 1002], 1000), Level.WARN,
         'other users run or have run here (uid 1001, 1002, this one 1000)',
         'FASTDDS_BUILTIN_TRANSPORTS=UDPv4')


# Fast DDS


def test_profile(tmp_path: Path) -> None:
    """Not set, set for the next Fast DDS, missing, broken, too small, without shared memory."""
    shipped = config_path('fastdds.xml')
    export = f'export FASTRTPS_DEFAULT_PROFILES_FILE={shipped}'
    told(profile.check_profile({}, shipped), Level.WARN, 'is not set', export)
    told(profile.check_profile({profile.LATER_VARIABLE: str(shipped)}, shipped), Level.WARN,
         'FASTDDS_DEFAULT_PROFILES_FILE is set, which Fast DDS 2 does not read', export)
    told(profile.check_profile({profile.VARIABLE: '/no.xml'}, shipped), Level.ERROR, '/no.xml',
         export)
    told(profile.check_profile({profile.VARIABLE: str(shipped)}, shipped), Level.OK, '32 MiB')
    mine = tmp_path / 'mine.xml'
    environment = {profile.VARIABLE: str(mine)}
    mine.write_text(shipped.read_text().replace('</dds>', ''))
    told(profile.check_profile(environment, shipped), Level.ERROR, 'no well-formed XML', export)
    mine.write_text(shipped.read_text().replace('33554432', '600000'))
    told(profile.check_profile(environment, shipped), Level.WARN, '600000 bytes', export)
    mine.write_text(shipped.read_text().replace('>SHM<', '>UDPv4<'))
    told(profile.check_profile(environment, shipped), Level.WARN, 'a segment of 0 bytes')
    mine.write_text(shipped.read_text().replace('is_default_profile="true"', ''))
    told(profile.check_profile(environment, shipped), Level.WARN, 'a segment of 524288 bytes')
    mine.write_text(shipped.read_text().replace('33554432', 'much'))
    told(profile.check_profile(environment, shipped), Level.ERROR, 'Fast DDS drops', 'getXMLUint')
    mine.write_text(shipped.read_text().replace('<type>SHM', '<queue>9</queue><type>SHM'))
    told(profile.check_profile(environment, shipped), Level.ERROR, 'Fast DDS drops', 'queue',
         export)
    assert not list(profile.check_profile({}, shipped, 'rmw_cyclonedds_cpp'))


# Discovery


def test_domain(tmp_path: Path) -> None:
    """No number, too large, and one whose ports others are given."""
    ports = tmp_path / 'ip_local_port_range'
    ports.write_text('32768\t60999\n')
    for wrong in ('abc', '233', '-1', '1.0'):
        told(discovery.check_domain({'ROS_DOMAIN_ID': wrong}, ports), Level.ERROR, wrong)
    told(discovery.check_domain({'ROS_DOMAIN_ID': '120'}, ports), Level.WARN, '37400', '32768')
    told(discovery.check_domain({'ROS_DOMAIN_ID': '101'}, ports), Level.OK, 'domain 101')
    told(discovery.check_domain({}, ports), Level.OK, 'domain 0')


@pytest.mark.parametrize(
    'environment, level, words',
    [
        ({}, Level.OK, 'SUBNET'),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}, Level.OK, 'this machine alone'),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'NEAR'}, Level.WARN, "'NEAR', which is none of SUBNET"),
        ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'OFF'}, Level.ERROR, 'export ROS_AUTOMATIC'),
        ({'ROS_LOCALHOST_ONLY': '1'}, Level.WARN, 'unset ROS_LOCALHOST_ONLY'),
        ({'ROS_LOCALHOST_ONLY': '0'}, Level.OK, 'SUBNET'),
    ],
)
def test_range(environment: dict[str, str], level: Level, words: str) -> None:
    """What Jazzy makes of each."""
    told(discovery.check_range(environment), level, words)


def test_multicast() -> None:
    """No network, a firewall, and a range that has no use for it."""

    def unreachable() -> None:
        raise OSError(errno.ENETUNREACH, 'Network is unreachable')

    def silent() -> None:
        raise TimeoutError('timed out')

    told(discovery.check_multicast({}, unreachable), Level.WARN, 'Network is unreachable', 'ufw')
    told(discovery.check_multicast({}, silent), Level.WARN, 'does not come back')
    told(discovery.check_multicast({}, lambda: None), Level.OK, 'comes back')
    for local in ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}, {'ROS_LOCALHOST_ONLY': '1'}):
        assert not list(discovery.check_multicast(local, silent))


# Security


def library(folder: Path, content: bytes) -> Path:
    """Make something that passes for libfastrtps."""
    path = folder / 'libfastrtps.so.2.14.5'
    path.write_bytes(b'\x7fELF' + content)
    return path


def test_security_that_is_not_built_in(tmp_path: Path) -> None:
    """Asked for and not there; how bad depends on what is to happen then."""
    without = library(tmp_path, bytes(5000))
    told(security.check_security({}, without), Level.OK, 'has no security plugins')
    asked = {'ROS_SECURITY_ENABLE': 'true'}
    told(security.check_security(asked, without), Level.WARN, 'nothing is secured', 'unset')
    enforced = {**asked, 'ROS_SECURITY_STRATEGY': 'Enforce'}
    told(security.check_security(enforced, without), Level.ERROR, 'no node can start', 'unset')
    told(security.check_security({'ROS_SECURITY_ENABLE': 'TRUE'}, without), Level.WARN,
         'just the word true counts')
    assert not list(security.check_security(enforced, None))


def test_keystore(tmp_path: Path) -> None:
    """None, one that is none, one without enclaves, and a whole one."""
    there = library(tmp_path, b'...dds.sec.auth.plugin...')
    told(security.check_security({}, there), Level.OK, 'has the security plugins')
    enforced = {'ROS_SECURITY_ENABLE': 'true', 'ROS_SECURITY_STRATEGY': 'Enforce'}
    told(security.check_security(enforced, there), Level.ERROR, 'ROS_SECURITY_KEYSTORE is not set')
    keystore = tmp_path / 'keystore'
    enforced['ROS_SECURITY_KEYSTORE'] = str(keystore)
    told(security.check_security(enforced, there), Level.ERROR, 'no keystore', 'create_keystore')
    (keystore / 'enclaves').mkdir(parents=True)
    (keystore / 'enclaves' / 'governance.p7s').touch()
    told(security.check_security(enforced, there), Level.ERROR, 'no enclave', 'create_enclave')
    (keystore / 'enclaves' / 'blob_tracker' / 'camera').mkdir(parents=True)
    (keystore / 'enclaves' / 'blob_tracker' / 'camera' / 'permissions.p7s').touch()
    told(security.check_security(enforced, there), Level.OK, 'enclaves /blob_tracker/camera')
    strategy, _ = security.check_security({**enforced, 'ROS_SECURITY_STRATEGY': 'enforce'}, there)
    assert strategy.level is Level.WARN
    assert "'enforce': anything but Enforce" in strategy.message


# Logs


def test_log_folder(tmp_path: Path) -> None:
    """Where it is, one that cannot be made, and a full disk."""
    told(log_folder.check_log_folder({'ROS_LOG_DIR': '/proc/logs'}), Level.WARN, '/proc/logs',
         'without log files', 'export ROS_LOG_DIR=')
    (tmp_path / 'file').touch()
    told(log_folder.check_log_folder({'ROS_LOG_DIR': str(tmp_path / 'file')}), Level.WARN)
    assert log_folder.log_folder({'ROS_HOME': '/r', 'HOME': '/h'}) == Path('/r/log')
    assert log_folder.log_folder({'HOME': '/h'}) == Path('/h/.ros/log')
    told([log_folder.judge_room(tmp_path, 5 * MIB)], Level.WARN, '5 MiB', 'make room', 'du -sh')
    told([log_folder.judge_room(tmp_path, 2**30)], Level.OK, '1.0 GiB')


# Cameras


class Webcam:
    """A driver that answers what the doctor asks."""

    def __init__(
        self, capabilities: int, formats: dict[str, list[tuple[int, int]]],
        driver: bytes = b'uvcvideo',
    ) -> None:
        self.capabilities, self.driver = capabilities, driver
        self.formats = formats

    def __call__(self, fd: int, number: int, argument: Any) -> None:
        if number == videodev2.QUERYCAP:
            argument.driver, argument.card = self.driver, b'HD Webcam'
            argument.bus_info, argument.capabilities = b'usb-0000:00:14.0-1', self.capabilities
            return
        assert number in (videodev2.ENUM_FMT, videodev2.ENUM_FRAMESIZES)  # nothing that changes it
        if number == videodev2.ENUM_FMT:
            names = list(self.formats)
            if argument.index < len(names):
                argument.pixelformat = videodev2.fourcc(names[argument.index])
                return
        else:
            sizes = self.formats[videodev2.fourcc_name(argument.pixel_format)]
            if argument.index < len(sizes):
                argument.type = videodev2.FRMSIZE_TYPE_DISCRETE
                # width and height, where v4l2_frmsizeenum has them for this type
                argument.min_width, argument.max_width = sizes[argument.index]
                return
        raise OSError(errno.EINVAL, 'Invalid argument')


STREAMS = videodev2.CAP_VIDEO_CAPTURE | videodev2.CAP_STREAMING
FORMATS = {'YUYV': [(640, 480), (320, 240)], 'H264': [(1920, 1080)]}


def devices(folder: Path) -> Path:
    """Make /dev with a camera in it, and a link by its name."""
    (folder / 'v4l' / 'by-id').mkdir(parents=True)
    (folder / 'video2').touch()
    (folder / 'v4l' / 'by-id' / 'usb-HD_Webcam').symlink_to(folder / 'video2')
    return folder


def test_no_camera(tmp_path: Path) -> None:
    """It is said where one would be."""
    told(cameras.check_cameras(tmp_path, tmp_path), Level.WARN, f'no {tmp_path}/video*', 'dmesg')
    told(cameras.check_camera('/dev/no_such_camera'), Level.ERROR, 'there is no such device')
    told(cameras.check_camera('/dev/null'), Level.ERROR, 'not a V4L2 device')
    told(cameras.check_stream('/dev/null'), Level.ERROR, 'not a V4L2 device')


def test_camera_with_its_formats(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Name, driver, bus, the link that stays, and what can be read of it."""
    monkeypatch.setattr(videodev2, 'ioctl', Webcam(STREAMS, FORMATS))
    found = one(cameras.check_cameras(devices(tmp_path), tmp_path / 'proc'))
    assert found == ok(
        'camera',
        f'{tmp_path}/video2: HD Webcam (uvcvideo, usb-0000:00:14.0-1), '
        f'{tmp_path}/v4l/by-id/usb-HD_Webcam: YUYV 640x480, 320x240',
    )


def test_a_sensor_behind_a_media_controller_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the subdevice that has its controls."""
    monkeypatch.setattr(videodev2, 'ioctl', Webcam(STREAMS, FORMATS, b'unicam'))
    monkeypatch.setattr(
        'blob_tracker.capture.sensor.of_video_device',
        lambda fd: (Sensor('imx219 10-0010', ((81, 5),)), ['/dev/v4l-subdev0']))
    found = one(cameras.check_cameras(devices(tmp_path), tmp_path / 'proc'))
    assert ', sensor imx219 10-0010 (/dev/v4l-subdev0): YUYV' in found.message


def test_cameras_that_cannot_be_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No format that can be read; no camera at all, which many have beside them."""
    folder = devices(tmp_path)
    monkeypatch.setattr(videodev2, 'ioctl', Webcam(STREAMS, {'H264': [(640, 480)]}))
    told(cameras.check_cameras(folder, tmp_path), Level.ERROR, '(H264) can be read; one of ',
         '--list-formats-ext')
    monkeypatch.setattr(videodev2, 'ioctl', Webcam(videodev2.CAP_META_CAPTURE, {}))
    told(cameras.check_cameras(folder, tmp_path), Level.OK, 'a metadata device, no pictures')
    loopback = Webcam(videodev2.CAP_VIDEO_OUTPUT, {}, b'v4l2 loopback')
    monkeypatch.setattr(videodev2, 'ioctl', loopback)
    told(cameras.check_cameras(folder, tmp_path), Level.WARN, 'no program writes pictures')
    monkeypatch.setattr(videodev2, 'ioctl', Webcam(0, {}, b'v4l2 loopback'))
    told(cameras.check_cameras(folder, tmp_path), Level.WARN, 'lets no other one write')


def test_camera_that_another_program_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the name and number of the process."""
    folder = devices(tmp_path)
    (tmp_path / 'proc' / '4711' / 'fd').mkdir(parents=True)
    (tmp_path / 'proc' / '4711' / 'comm').write_text('guvcview\n')
    (tmp_path / 'proc' / '4711' / 'fd' / '7').symlink_to(folder / 'video2')
    (tmp_path / 'proc' / '4712').mkdir()  # one that may not be looked into
    monkeypatch.setattr(videodev2, 'ioctl', Webcam(STREAMS, FORMATS))
    told(cameras.check_cameras(folder, tmp_path / 'proc'), Level.WARN, 'open in guvcview (4711)',
         'fuser -v')


def test_camera_that_may_not_be_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The group to join is named."""
    folder = devices(tmp_path)
    os.chmod(folder / 'video2', 0o660)
    stat = os.stat  # making it root's takes root

    def refuse(path: str, flags: int) -> int:
        raise PermissionError(errno.EACCES, 'Permission denied')

    def of_root_and_video(path: str, **options: Any) -> os.stat_result:
        status = stat(path, **options)
        if str(path) != f'{folder}/video2':
            return status
        return os.stat_result((*status[:4], 0, 44, *status[6:]))

    monkeypatch.setattr('blob_tracker.capture.device.os.open', refuse)
    monkeypatch.setattr('blob_tracker.capture.device.os.stat', of_root_and_video)
    told(cameras.check_cameras(folder, tmp_path), Level.ERROR, 'permission denied',
         'sudo usermod -aG video')


@pytest.mark.parametrize('drops, level, order, words', [
    (0, Level.OK, 'none', ''), (3, Level.WARN, 'none', ''),
    (0, Level.OK, 'seq_tb', ', fields top before bottom, one above the other'),
])
def test_frames_of_a_camera(
    drops: int, level: Level, order: str, words: str, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Their size, rate and brightness, after what the device says of itself."""

    class Stream:
        width, height, pixel_format, saturation = 640, 480, 'YUYV', 235
        fields = FieldStream(order, 480)
        stamp_ns = 0

        def __init__(self, path: str) -> None:
            self.drops = drops

        def __enter__(self) -> Stream:
            return self

        def __exit__(self, *error: object) -> None:
            pass

        def read(self, timeout: float) -> Frame:
            Stream.stamp_ns += 40_000_000
            return Frame(np.full((480, 640), 99, np.uint8), Stream.stamp_ns, 235)

    monkeypatch.setattr(videodev2, 'ioctl', Webcam(STREAMS, FORMATS))
    monkeypatch.setattr(blob_tracker.capture, 'V4l2Camera', Stream)
    device, stream = cameras.check_stream(f'{devices(tmp_path)}/video2')
    assert device.level is Level.OK
    assert stream.level is level
    assert f'640x480 YUYV{words} at 25.0 frames/s, {drops} lost' in stream.message
    assert 'the brightest pixel 99 of 235 DN' in stream.message


# The self-test


@pytest.mark.parametrize(
    'changes, level, words',
    [
        ({}, Level.OK, '60 bearings in 2 s'),
        ({'fault': 'no bearing came within 20 s'}, Level.ERROR, 'no bearing came'),
        ({'rms': 0.06}, Level.ERROR, 'the budget is missed'),
        ({'rms': float('nan')}, Level.ERROR, 'the budget is missed'),
        ({'false': 2}, Level.ERROR, '2 bearings for frames without light'),
        ({'located': 48}, Level.WARN, '12 of 60 lit frames lost'),
        ({'latency': 0.03}, Level.WARN, '30.0 ms median'),
        ({'rate': 40.0}, Level.WARN, '40 frames/s'),
    ],
)
def test_verdict_of_the_self_test(changes: dict[str, Any], level: Level, words: str) -> None:
    """What is right, and each thing that may not be."""
    run = {'rate': 60.0, 'lit': 60, 'located': 60, 'rms': 0.01, 'latency': 0.004,
           'latency_p99': 0.01}
    if 'fault' in changes:
        run = {}
    finding = judge(Run(domain=7, **{**run, **changes}))
    assert finding.level is level
    assert words in finding.message


def test_a_domain_that_is_free() -> None:
    """None of its ports is open."""
    udp = ['  sl  local_address rem_address   st']
    udp += [f'  1: 00000000:{7400 + 250 * domain + 11:04X} 00000000:0000 07'
            for domain in range(1, 102) if domain != 33]
    assert free_domain('\n'.join(udp)) == 33


# The whole


def test_a_check_that_fails_is_a_finding() -> None:
    """And what it had found before counts."""

    def check() -> Iterable[Finding]:
        yield ok('disk', 'there is one')
        raise CaptureError('the moon is in the way')

    first, second = examined('disk', check)
    assert first.level is Level.OK
    assert second.level is Level.ERROR
    assert 'CaptureError: the moon is in the way' in second.message


def test_report(capsys: pytest.CaptureFixture[str]) -> None:
    """Level in words, markup left alone, commands on lines of their own; JSON holds it all."""
    findings = [ok('a', 'fine [red]'), warn('b', 'so so', 'do', 'export X=' + 'y' * 200),
                error('c', 'bad')]
    report = Report()
    for finding in findings:
        report.tell(finding)
    report.conclude(findings)
    lines = capsys.readouterr().out.splitlines()
    assert [line.rstrip() for line in lines] == [
        'OK     a               fine [red]',
        'WARN   b               so so; do:',
        f'       export X={"y" * 200}',
        'ERROR  c               bad',
        '',
        '1 error, 1 warning',
    ]
    assert json.loads(as_json(findings))[1] == {
        'level': 'WARN', 'subject': 'b', 'message': 'so so', 'advice': 'do',
        'command': f'export X={"y" * 200}',
    }
    assert summary(findings[:1]) == 'All is well.'


def run_doctor(*options: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run it as a user does."""
    return subprocess.run([*DOCTOR, *options], capture_output=True, text=True,
                          timeout=100 * slowness(), env={**os.environ, **environment})


def test_real_nodes_pass_the_self_test() -> None:
    """Three processes, a truth to compare with, no error; exit code 0."""
    result = run_doctor('--json')
    findings = json.loads(result.stdout)
    assert not [f for f in findings if f['level'] == 'ERROR'], result.stdout
    assert result.returncode == 0
    # A machine busy with other tests may be told so, but bearings come and are right.
    (self_test,) = [f for f in findings if f['subject'] == 'self-test']
    assert ' px rms a coordinate' in self_test['message']
    for subject in ('Python', 'libraries', 'ROS', 'RMW', 'TF', 'package', 'kernels',
                    'shared memory', 'Fast DDS', 'discovery', 'security', 'log folder', 'camera'):
        assert [f for f in findings if f['subject'] == subject], subject
    library = profile.fast_dds(installation.library_folders(os.environ, Path(rclpy.__file__)))
    assert f'has {"the" if security.has_security(library) else "no"} security plugins' in next(
        f['message'] for f in findings if f['subject'] == 'security')


def test_a_middleware_that_is_not_there_does_not_end_the_doctor() -> None:
    """Whoever loads rclpy then is ended by it."""
    result = run_doctor(RMW_IMPLEMENTATION='rmw_no_such_cpp')
    assert result.returncode == 1
    assert 'ERROR  RMW' in result.stdout
    assert '1 error, ' in result.stdout
    assert 'left out: no node can run here; see RMW above' in result.stdout


def test_where_there_is_no_ros(tmp_path: Path) -> None:
    """The core alone: an error that says what still works, and no traceback."""
    (tmp_path / 'sitecustomize.py').write_text(
        'from importlib.machinery import PathFinder\n'
        'find = PathFinder.find_spec\n'
        "ROS = ('rclpy', 'ament_index_python', 'sensor_msgs')\n"
        'PathFinder.find_spec = lambda name, *rest: (\n'
        "    None if name.partition('.')[0] in ROS else find(name, *rest))\n"
    )
    package = Path(blob_tracker.__file__).parents[1]
    result = run_doctor(PYTHONPATH=f'{tmp_path}{os.pathsep}{package}')
    assert result.returncode == 1
    assert 'there is no rclpy for this Python' in result.stdout
    assert '1 error, ' in result.stdout
    assert 'Traceback' not in result.stdout + result.stderr
