"""Packages of a Debian release, unpacked into a folder: nothing is installed on this machine."""

from __future__ import annotations

from collections.abc import Sequence
import os
from pathlib import Path
import re
import shlex
import subprocess
import time

# depmod and modprobe live in sbin, which users' PATHs often leave out.
PATH = os.pathsep.join((os.environ.get('PATH', os.defpath), '/usr/sbin', '/sbin'))
RELEASES = {'12': 'bookworm', '13': 'trixie'}  # name of each version
KEYS = '/usr/share/keyrings/debian-archive-keyring.gpg'
SOURCES = f"""\
deb [arch=amd64 signed-by={KEYS}] http://deb.debian.org/debian @RELEASE@ main
deb [arch=amd64 signed-by={KEYS}] http://deb.debian.org/debian-security @RELEASE@-security main
"""
CURRENT = 86_400.0  # s for which lists of packages are taken to be


class MachineError(RuntimeError):
    """The machine cannot be built or does not end as it should; the message says why."""


class Debian:
    """
    The packages of a release, whatever release this machine runs.

    Parameters
    ----------
    version : str
        One of `RELEASES`.
    cache : Path
        Folder for the lists of packages, made where it is missing.

    Raises
    ------
    MachineError
        There is no such release here, or its lists cannot be had.

    """

    def __init__(self, version: str, cache: Path) -> None:
        if version not in RELEASES:
            raise MachineError(f'Debian {version} is not known here; choose one of '
                               f'{", ".join(RELEASES)}')
        folder = cache / f'debian{version}'
        lists = folder / 'lists'
        (folder / 'archives/partial').mkdir(parents=True, exist_ok=True)
        (folder / 'sources.list').write_text(SOURCES.replace('@RELEASE@', RELEASES[version]))
        self._options = [
            '-q', *(f'-o={name}={value}' for name, value in {
                'Dir::Etc::SourceList': folder / 'sources.list',
                'Dir::Etc::SourceParts': '/dev/null',
                'Dir::State::Lists': lists,
                'Dir::State::Status': '/dev/null',
                'Dir::Cache': folder,
                'APT::Architecture': 'amd64',
                'APT::Sandbox::User': 'root',  # the folder need not be everybody's
                'Acquire::Languages': 'none',
            }.items())]
        if not lists.is_dir() or time.time() - lists.stat().st_mtime > CURRENT:
            (lists / 'partial').mkdir(parents=True, exist_ok=True)
            run('apt-get', *self._options, '-o=APT::Update::Error-Mode=any', 'update')
            os.utime(lists)

    def depends(self, package: str, pattern: str) -> list[str]:
        """Return the packages that one depends on whose names match as a whole."""
        known = run('apt-cache', *self._options, 'depends', package)
        return [name for name in re.findall(r'Depends: (\S+)', known)
                if re.fullmatch(pattern, name)]

    def version(self, package: str) -> str:
        """Return the version of a package."""
        known = run('apt-cache', *self._options, 'policy', package)
        found = re.search(r'Candidate: (\d\S*)', known)
        if not found:
            raise MachineError(f'Debian has no package {package} here')
        return found[1]

    def unpack(self, packages: Sequence[str], folder: Path) -> None:
        """Download packages and unpack them into a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        run('apt-get', *self._options, 'download', *packages, cwd=folder)
        for archive in folder.glob('*.deb'):
            run('dpkg-deb', '-x', str(archive), str(folder))
            archive.unlink()


def run(*command: str, cwd: Path | None = None) -> str:
    """Return what a program prints."""
    try:
        done = subprocess.run(
            command, cwd=cwd, env={**os.environ, 'PATH': PATH, 'LC_ALL': 'C'}, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=300)
    except subprocess.TimeoutExpired as error:
        raise MachineError(f'{shlex.join(command)} did not end within 300 s') from error
    if done.returncode:
        raise MachineError(f'{shlex.join(command)} failed: {done.stderr.strip()}')
    return done.stdout
