"""The loops over pixels: whether they are compiled, and can be kept."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
import json
from pathlib import Path
import subprocess
import sys

from blob_tracker.nodes.doctor.finding import error, Finding, ok, warn

COMPILE = (
    "cd / && python -c 'from blob_tracker import location, segmentation; "
    "location.compile_ahead(); segmentation.compile_ahead()'"
)
TELL = (
    'import json; from blob_tracker import location, segmentation; '
    'from blob_tracker.kernel import compiled; '
    "print(json.dumps({r: compiled(f'blob_tracker.{r}') for r in ('location', 'segmentation')}))"
)
TIMEOUT = 60.0  # s to load Numba, on a machine that is busy


def check_compiled(environment: Mapping[str, str], place: Path | None) -> Iterator[Finding]:
    """
    Look for the machine code that Numba keeps of each room's loops.

    Parameters
    ----------
    environment : mapping
        Environment variables.
    place : Path or None
        The folder to look from: Python prefers the package of the folder that it is started in,
        and the nodes' is meant. None is this one.

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
        yield judge(json.loads(result.stdout))
        return
    last = (result.stderr.strip().splitlines() or ['it says nothing'])[-1]
    if 'no locator available' in last:  # Numba's words, which has looked in several places
        yield error(
            'kernels', 'Numba finds no folder that it may write its machine code to',
            'name one', 'export NUMBA_CACHE_DIR=$HOME/.cache/numba',
        )
    else:
        yield error('kernels', f'they cannot be loaded: {last}', 'see the libraries above')


def judge(compiled: Mapping[str, tuple[int, int, str]]) -> Finding:
    """
    Return the finding.

    Parameters
    ----------
    compiled : mapping
        room -> how many of its loops are compiled for this processor, how many it has, and the
        folder that the machine code is in.

    """
    words = ', '.join(f'{room} {done} of {all_}' for room, (done, all_, _) in compiled.items())
    folder = next(iter(compiled.values()))[2]
    words = f'compiled for this processor: {words}, in {folder}'
    if all(done for done, _, _ in compiled.values()):
        return ok('kernels', words)
    return warn(
        'kernels',
        f'{words}; a node compiles what it lacks as it starts, which takes half a minute, once',
        'to do it now',
        COMPILE,
    )
