"""Drivers that Debian's kernels do not carry, built for one of them: v4l2loopback and vimc."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
import shutil
import tarfile

from vm.debian import Debian, run

VIMC = 'drivers/media/test-drivers/vimc'
ELF = b'\x7fELF'


def build(release: Debian, kernel: str, loopbacks: Iterable[Debian], folder: Path) -> None:
    """
    Build vimc and a v4l2loopback of each of some releases for a kernel.

    Parameters
    ----------
    release : Debian
        That of the kernel.
    kernel : str
        Its version, as uname has it.
    loopbacks : iterable of Debian
        Releases whose v4l2loopback is built.
    folder : Path
        Gets vimc.ko, and v4l2loopback-X.Y.Z.ko of each.

    Raises
    ------
    MachineError
        Something cannot be had, or is not built.

    """
    work = folder / 'work'
    root = work / 'headers'
    headers = f'linux-headers-{kernel}'
    needed = release.depends(headers, r'linux-headers-.*-common|linux-kbuild-.*')
    release.unpack([headers, *needed], root)
    tree = root / 'usr/src' / headers
    makefile = tree / 'Makefile'
    makefile.write_text(makefile.read_text().replace(' /usr/src/', f' {root}/usr/src/'))
    (tree / 'vmlinux').unlink(missing_ok=True)  # types for tracers, which take another tool
    _bring_libc(release, root)
    for each in loopbacks:
        source = work / each.version('v4l2loopback-dkms')
        each.unpack(['v4l2loopback-dkms'], source)
        code = next(source.glob('usr/src/v4l2loopback-*'))
        _make(tree, code)
        shutil.copy(code / 'v4l2loopback.ko', folder / f'{code.name}.ko')
    code = _vimc(release, kernel, work)
    _make(tree, code)
    shutil.copy(code / 'vimc.ko', folder)
    shutil.rmtree(work)


def _bring_libc(release: Debian, root: Path) -> None:
    """Have the programs that build modules run with the release's own C library."""
    release.unpack(['libc6'], root / 'libc')
    loader = next((root / 'libc').rglob('x86_64-linux-gnu/ld-linux-x86-64.so.2'))
    for program in (root / 'usr/lib').rglob('*'):
        if program.is_symlink() or not program.is_file() or program.read_bytes()[:4] != ELF:
            continue
        real = program.rename(f'{program}.elf')
        program.write_text(f'#!/bin/sh\nexec {loader} --argv0 "$0" --library-path '
                           f'{loader.parent} {real} "$@"\n')
        program.chmod(0o755)


def _vimc(release: Debian, kernel: str, folder: Path) -> Path:
    """Return the folder with vimc's source, from the package of the whole kernel's."""
    name = 'linux-source-' + '.'.join(kernel.split('.')[:2])
    release.unpack([name], folder)
    archive = folder / f'usr/src/{name}.tar.xz'
    code = folder / 'vimc'
    code.mkdir()
    with tarfile.open(archive, 'r|xz') as source:
        for member in source:
            if f'/{VIMC}/' in member.name:
                file = source.extractfile(member)
                assert file
                (code / Path(member.name).name).write_bytes(file.read())
            elif any(code.iterdir()):
                break  # the rest would take as long again
    archive.unlink()
    return code


def _make(tree: Path, code: Path) -> None:
    """Build the module whose source is in a folder."""
    run('make', '-s', '-C', str(tree), f'M={code}', 'CONFIG_VIDEO_VIMC=m', 'CC=gcc',
        # Debian's compiler has an option for it that an older one has not.
        'CONFIG_CC_HAS_MIN_FUNCTION_ALIGNMENT=', 'modules')
