"""SROS2: whether this Fast DDS can enforce it, and is asked to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
import mmap
from pathlib import Path

from blob_tracker.commands.doctor.finding import error, Finding, ok, warn

# Name of a property that just a Fast DDS with security reads. Checked on 2.14.5 from PyPI, built
# without it, and on 2.9.1 from Debian, built with it.
MARKER = b'dds.sec.auth.plugin'
STRATEGIES = ('Enforce', 'Permissive')


def has_security(library: Path) -> bool:
    """Tell whether a library of Fast DDS was built with its security plugins."""
    with open(library, 'rb') as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as code:
        return code.find(MARKER) >= 0


def check_security(
    environment: Mapping[str, str], library: Path | None
) -> Iterator[Finding]:
    """
    Look at whether SROS2 is there, is wanted, and has what it needs.

    Parameters
    ----------
    environment : mapping
        Environment variables.
    library : Path or None
        That of Fast DDS.

    """
    if library is None:
        return  # the middleware's check has said so
    there = has_security(library)
    wanted = environment.get('ROS_SECURITY_ENABLE', '')
    state = f'{library.name} has {"the" if there else "no"} security plugins'
    if wanted != 'true':  # rcl takes it to the letter
        if wanted.lower() in ('1', 'yes', 'on', 'true'):
            yield warn(
                'security', f'ROS_SECURITY_ENABLE is {wanted!r}; just the word true counts: '
                'nothing is secured', 'to have it', 'export ROS_SECURITY_ENABLE=true',
            )
            return
        yield ok('security', f'{state}; it is not asked for (ROS_SECURITY_ENABLE)')
        return
    strategy = environment.get('ROS_SECURITY_STRATEGY', 'Permissive')
    if not there:
        level, what = (
            (error, 'no node can start') if strategy == 'Enforce' else (warn, 'nothing is secured')
        )
        yield level(
            'security',
            f'ROS_SECURITY_ENABLE is true and {state}: {what}; that of PyPI has none',
            'use ROS 2 from apt for it, or do without',
            'unset ROS_SECURITY_ENABLE',
        )
        return
    if strategy not in STRATEGIES:
        yield warn(
            'security',
            f'ROS_SECURITY_STRATEGY is {strategy!r}: anything but Enforce lets nodes run without '
            'keys',
            'to have them refused',
            'export ROS_SECURITY_STRATEGY=Enforce',
        )
    yield from _check_keystore(environment, strategy)


def _check_keystore(environment: Mapping[str, str], strategy: str) -> Iterator[Finding]:
    """Look at whether the keystore is one, and which enclaves it has."""
    level = error if strategy == 'Enforce' else warn
    name = environment.get('ROS_SECURITY_KEYSTORE', '')
    create = 'ros2 security create_keystore ~/keystore'
    if not name:
        yield level(
            'security',
            'ROS_SECURITY_ENABLE is true and ROS_SECURITY_KEYSTORE is not set: there are no keys',
            'name the keystore',
            'export ROS_SECURITY_KEYSTORE=$HOME/keystore',
        )
        return
    enclaves = Path(name) / 'enclaves'
    if not (enclaves / 'governance.p7s').is_file():
        yield level(
            'security',
            f'ROS_SECURITY_KEYSTORE is {name}, which is not a keystore: {enclaves} has no '
            'governance.p7s',
            'make one (config/security/README.md)',
            create,
        )
        return
    names = sorted(
        f'/{path.parent.relative_to(enclaves)}' for path in enclaves.rglob('permissions.p7s')
    )
    if not names:
        yield level(
            'security', f'the keystore {name} has no enclave: no node has keys',
            'make them (config/security/README.md)',
            f'ros2 security create_enclave {name} /blob_tracker/locator',
        )
        return
    yield ok('security', f'{strategy}, enclaves {", ".join(names)}')
