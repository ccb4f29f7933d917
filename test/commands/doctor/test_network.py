"""The Fast DDS profile, discovery and security, each made wrong for the doctor."""

from __future__ import annotations

import errno
from pathlib import Path

from blob_tracker.commands.doctor import discovery, profile, security
from blob_tracker.commands.doctor.finding import Level
from blob_tracker.resources import config_path
import pytest
from support.findings import told


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
    told(profile.check_profile(environment, shipped), Level.ERROR, 'is not well-formed XML',
         export)
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
    told(security.check_security(enforced, there), Level.ERROR, 'is not a keystore',
         'create_keystore')
    (keystore / 'enclaves').mkdir(parents=True)
    (keystore / 'enclaves' / 'governance.p7s').touch()
    told(security.check_security(enforced, there), Level.ERROR, 'no enclave', 'create_enclave')
    (keystore / 'enclaves' / 'blob_tracker' / 'camera').mkdir(parents=True)
    (keystore / 'enclaves' / 'blob_tracker' / 'camera' / 'permissions.p7s').touch()
    told(security.check_security(enforced, there), Level.OK, 'enclaves /blob_tracker/camera')
    strategy, _ = security.check_security({**enforced, 'ROS_SECURITY_STRATEGY': 'enforce'}, there)
    assert strategy.level is Level.WARN
    assert "'enforce': anything but Enforce" in strategy.message
