"""The loops over pixels: whether they are compiled, and can be kept."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
import json
from pathlib import Path
import shlex
import subprocess
import sys

from blob_tracker.commands.doctor.finding import error, Finding, ok, warn

ROOMS = ('location', 'segmentation', 'tracking', 'constellation')
# Modules with the loops that run with the parameters as they are by default, and no others.
NEEDED = (
    'location.contract', 'location.maximum_likelihood', 'segmentation.adaptive_moments',
    'segmentation.description', 'segmentation.local_maxima', 'segmentation.peaks',
    'segmentation.tile_noise', 'tracking.angular_velocity', 'tracking.constant_velocity',
    'tracking.direction', 'tracking.gyro_faults', 'tracking.kalman', 'tracking.packed',
    'tracking.rotation',
)
COMPILE = 'from blob_tracker.pipeline import compile_ahead; compile_ahead({})'  # the methods
TELL = (
    'import json; from blob_tracker import constellation, location, segmentation, tracking; '
    'from blob_tracker.kernel import compiled; '
    f"print(json.dumps({{m: compiled(f'blob_tracker.{{m}}') for m in {ROOMS + NEEDED}}}))"
)
TIMEOUT = 60.0  # s to load Numba, on a machine that is busy


def check_compiled(environment: Mapping[str, str], place: Path) -> Iterator[Finding]:
    """
    Look for the machine code that Numba keeps of each room's loops.

    Parameters
    ----------
    environment : mapping
        Environment variables.
    place : Path
        The folder to look from: Python prefers the package of the folder that it is started in,
        which may be a source tree beside the package that is installed.

    """
    if environment.get('NUMBA_DISABLE_JIT', '0') != '0':
        yield error(
            'kernels', 'NUMBA_DISABLE_JIT is set: each fit takes a hundred times as long',
            'without it', 'unset NUMBA_DISABLE_JIT',
        )
        return
    result = subprocess.run(
        [sys.executable, '-c', TELL], cwd=place, env=dict(environment), timeout=TIMEOUT,
        capture_output=True, text=True,
    )
    if result.returncode == 0:
        yield judge(json.loads(result.stdout), place)
        return
    last = (result.stderr.strip().splitlines() or ['it says nothing'])[-1]
    if 'no locator available' in last:  # Numba's words, which has looked in several places
        yield error(
            'kernels', 'Numba finds no folder that it may write its machine code to',
            'name one', 'export NUMBA_CACHE_DIR=$HOME/.cache/numba',
        )
    else:
        yield error('kernels', f'they cannot be loaded: {last}', 'see the libraries above')


def judge(compiled: Mapping[str, tuple[int, int, str]], place: Path) -> Finding:
    """
    Return the finding.

    Parameters
    ----------
    compiled : mapping
        Each of `ROOMS` and `NEEDED` -> how many of its loops are compiled for this processor, how
        many it has, and the folder that the machine code is in.
    place : Path
        Where Python finds that package.

    """
    words = ', '.join('{} {} of {}'.format(room, *compiled[room][:2]) for room in ROOMS)
    words = f'compiled for this processor: {words}, in {compiled[ROOMS[0]][2]}'
    lacking = [module for module in NEEDED if compiled[module][0] < compiled[module][1]]
    if not lacking:
        return ok('kernels', words)
    return warn(
        'kernels',
        f'{words}; not all that the defaults need ({", ".join(lacking)}): a node compiles what it '
        'lacks as it starts, once, for up to seven minutes',
        'to do it now',
        f'cd {shlex.quote(str(place))} && {shlex.quote(sys.executable)} -c '
        f'{shlex.quote(COMPILE.format(""))}',
    )
