"""
A machine with V4L2 drivers: Debian's kernel with `vivid` and `uvcvideo`, booted under QEMU.

The guest sees the host's root read-only under an overlay in memory, at the same paths: it runs
this very Python and this very package. One folder, `results`, is writable and stays.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
import gzip
import lzma
import os
from pathlib import Path
import shlex
import shutil
import subprocess
import sys
import time

from vm import modules
from vm.debian import Debian, KEYS, MachineError, PATH, run as _run

# Modules the guest needs beside those in Debian's kernel image itself.
MODULES = ('virtio_pci', '9pnet_virtio', '9p', 'overlay', 'vivid', 'vhci-hcd', 'uvcvideo')
# Two devices with an HDMI input that loops from an HDMI output: /dev/video0 and /dev/video1, and
# the same with multi-planar buffers: /dev/video2 and /dev/video3. The first has a TV and an
# S-Video input as well, and an S-Video output.
VIVID = ('n_devs=2 node_types=0x101,0x101 num_inputs=3,1 input_types=0x27,0x3 num_outputs=2,1 '
         'output_types=0x1,0x1 multiplanar=1,2')
TOOLS = {  # program -> Debian package
    'qemu-system-x86_64': 'qemu-system-x86',
    'busybox': 'busybox-static',
    'cpio': 'cpio',
    'depmod': 'kmod',
    'modprobe': 'kmod',
    'v4l2-ctl': 'v4l-utils',
    'media-ctl': 'v4l-utils',
    'apt-get': 'apt',
    'dpkg-deb': 'dpkg',
    'gcc': 'gcc',
    'make': 'make',
}
# Whose kernel is booted, and whose v4l2loopback it gets.
DEBIAN = os.environ.get('DEBIAN', '12')
LOOPBACKS = {'12': ('12', '13'), '13': ('13',)}

INIT = """\
#!/bin/busybox sh
/bin/busybox --install -s /bin
export PATH=/bin
echo "the kernel is up"
mount -t proc proc /proc
mount -t sysfs sys /sys
mount -t devtmpfs dev /dev
for module in $(cat /modules/order); do
  options=
  [ $module = vivid.ko ] && options="@VIVID@"
  insmod /modules/$module $options || echo "cannot load $module"
done
mkdir -p /host /memory /root
mount -t 9p -o trans=virtio,version=9p2000.L,ro,cache=loose,msize=512000 host /host
mount -t tmpfs memory /memory
mkdir /memory/upper /memory/work
mount -t overlay -o lowerdir=/host,upperdir=/memory/upper,workdir=/memory/work overlay /root
value() { sed -n "s/.*$1=\\([^ ]*\\).*/\\1/p" /proc/cmdline; }
# Thousands of small files, each of which would be looked up in both layers.
for folder in $(value python | tr : ' '); do
  mount --bind /host$folder /root$folder
done
mount -t proc proc /root/proc
mount -t sysfs sys /root/sys
mount --bind /dev /root/dev
mkdir -p /dev/shm
mount -t tmpfs shm /root/dev/shm
mount -t tmpfs tmp /root/run
ip link set lo up
results=$(value results)
mkdir -p /root$results
mount -t 9p -o trans=virtio,version=9p2000.L,msize=512000 results /root$results
echo "the driver is there: the scripts begin"
chroot /root /bin/sh $results/guest.sh
sync
umount /root$results
poweroff -f
"""


@dataclass(frozen=True)
class Boot:
    """
    What QEMU boots.

    Parameters
    ----------
    kernel, initramfs : Path
        Files in the cache.
    drivers : Path
        Folder with the modules of `modules.build`.

    """

    kernel: Path
    initramfs: Path
    drivers: Path


def missing_tools() -> str:
    """Return the Debian packages whose programs are not there, separated by spaces."""
    missing = {
        package for program, package in TOOLS.items() if not shutil.which(program, path=PATH)}
    if not Path(KEYS).exists():
        missing.add('debian-archive-keyring')
    return ' '.join(sorted(missing))


def build(cache: Path) -> Boot:
    """
    Make a kernel and an initramfs, or take those that an earlier call left in the cache.

    Parameters
    ----------
    cache : Path
        Folder, made where it is missing.

    Raises
    ------
    MachineError
        Debian's kernel cannot be had.

    """
    debian = Debian(DEBIAN, cache)
    package, = debian.depends('linux-image-amd64', 'linux-image-.*')
    folder = cache / f'{package}_{debian.version(package)}'
    version = package.removeprefix('linux-image-')
    unpacked = _once(folder / 'root', lambda made: _unpack_kernel(debian, package, version, made))
    drivers = _once(folder / 'drivers', lambda made: modules.build(
        debian, version, [Debian(each, cache) for each in LOOPBACKS[DEBIAN]], made))
    # Made again each time: it takes a second and follows every change of this file.
    initramfs = _make_initramfs(folder, unpacked, version)
    return Boot(unpacked / 'boot' / f'vmlinuz-{version}', initramfs, drivers)


def _once(folder: Path, make: Callable[[Path], None]) -> Path:
    """Return a folder, made where it is missing: what is there is whole."""
    if not folder.is_dir():
        partial = folder.with_name(f'{folder.name}.partial')
        shutil.rmtree(partial, ignore_errors=True)
        make(partial)
        partial.rename(folder)
    return folder


def _unpack_kernel(debian: Debian, package: str, version: str, folder: Path) -> None:
    debian.unpack([package], folder)
    if not (folder / 'lib').exists():
        (folder / 'lib').symlink_to('usr/lib')
    _run('depmod', '-b', str(folder), version)


def _make_initramfs(folder: Path, unpacked: Path, version: str) -> Path:
    tree = folder / 'initramfs'
    shutil.rmtree(tree, ignore_errors=True)
    for name in ('bin', 'modules', 'proc', 'sys', 'dev'):
        (tree / name).mkdir(parents=True)
    busybox = shutil.which('busybox', path=PATH)
    assert busybox
    shutil.copy(busybox, tree / 'bin')
    order: list[str] = []
    for module in MODULES:
        for line in _run('modprobe', '-d', str(unpacked), '-S', version, '--show-depends',
                         module).splitlines():
            kind, path = line.split(maxsplit=2)[:2]
            name = Path(path).name.removesuffix('.xz')
            if kind == 'insmod' and name not in order:
                order.append(name)
                content = Path(path).read_bytes()
                (tree / 'modules' / name).write_bytes(
                    lzma.decompress(content) if path.endswith('.xz') else content)
    (tree / 'modules/order').write_text('\n'.join(order))
    (tree / 'init').write_text(INIT.replace('@VIVID@', VIVID))
    (tree / 'init').chmod(0o755)
    names = '\n'.join(str(path.relative_to(tree)) for path in sorted(tree.rglob('*')))
    archive = subprocess.run(
        ['cpio', '-o', '-H', 'newc', '--quiet'], cwd=tree, input=names.encode(),
        stdout=subprocess.PIPE, check=True, timeout=60).stdout
    image = folder / 'initramfs.gz'
    image.write_bytes(gzip.compress(archive, 1))
    return image


def run(
    boot: Boot, commands: Sequence[str], results: Path, patience: Callable[[], float]
) -> None:
    """
    Boot, run shell commands as root in the guest, and power off.

    The console is kept in results/console.log and the commands' output in results/guest.log.

    Parameters
    ----------
    boot : Boot
        From `build`.
    commands : sequence of str
        Lines of the guest's shell script. It stops at the first that fails.
    results : Path
        Folder that the guest may write to, at the same path; without spaces.
    patience : callable
        Asked again and again for the longest time, s, in which nothing is written: neither on
        the console nor to a file in the folder. As long as something is, the machine lives.

    Raises
    ------
    MachineError
        A command failed, or nothing came of the machine any more; QEMU is killed then.

    """
    done = results / 'done'
    done.unlink(missing_ok=True)
    log = results / 'guest.log'
    script = '\n'.join([
        f'exec >{shlex.quote(str(log))} 2>&1', 'set -ex',
        'export PATH=/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin', *commands,
        f'touch {shlex.quote(str(done))}', ''])
    (results / 'guest.sh').write_text(script)
    command = [
        'qemu-system-x86_64', '-M', 'q35', '-accel', 'tcg,thread=multi', '-cpu', 'max',
        '-m', '2048', '-smp', '2', '-net', 'none', '-no-reboot',
        '-display', 'none', '-monitor', 'none', '-serial', 'stdio',
        '-kernel', str(boot.kernel), '-initrd', str(boot.initramfs),
        # On a busy host the emulated timer fails the kernel's test of its interrupt. Two emulated
        # processors share one time stamp counter; untrusted, each look at the clock is an access
        # to an emulated device.
        '-append', 'console=ttyS0 quiet mitigations=off no_timer_check tsc=reliable panic=-1 '
                   f'results={results} python={sys.prefix}:{sys.base_prefix}',
        '-virtfs', 'local,path=/,mount_tag=host,security_model=none,readonly=on,multidevs=remap',
        '-virtfs', f'local,path={results},mount_tag=results,security_model=none',
    ]
    with (results / 'console.log').open('wb') as console, subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=console, stderr=subprocess.STDOUT,
        env={**os.environ, 'PATH': PATH},
    ) as machine:
        try:
            _watch(machine, results, patience)
        finally:
            machine.kill()  # where it has not ended
    if machine.returncode:
        raise MachineError(f'QEMU ended with {machine.returncode}\n' + _last_lines(results))
    if not done.exists():
        raise MachineError('a command in the guest failed\n' + _last_lines(results))


def _watch(
    machine: subprocess.Popen[bytes], results: Path, patience: Callable[[], float]
) -> None:
    """Wait for the end, as long as something is written."""
    written, since = -1, time.monotonic()
    while True:
        try:
            machine.wait(1.0)
            return
        except subprocess.TimeoutExpired:
            size = sum(path.stat().st_size for path in results.iterdir() if path.is_file())
        if size != written:
            written, since = size, time.monotonic()
        elif time.monotonic() - since > patience():
            raise MachineError(f'nothing came of the machine for {time.monotonic() - since:.0f} s'
                               '\n' + _last_lines(results)) from None


def _last_lines(results: Path, count: int = 40) -> str:
    parts = []
    for name in ('console.log', 'guest.log'):
        path = results / name
        lines = path.read_text(errors='replace').splitlines() if path.exists() else []
        parts.append('\n'.join([f'--- {name}', *lines[-count:]]))
    return '\n'.join(parts)
