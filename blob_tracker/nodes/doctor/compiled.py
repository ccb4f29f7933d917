"""The loops over pixels: whether they are compiled, and can be kept."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module

from blob_tracker.nodes.doctor.finding import error, Finding, ok, warn

ROOMS = ('location', 'segmentation')
COMPILE = (
    "python -c 'from blob_tracker import location, segmentation; location.compile_ahead(); "
    "segmentation.compile_ahead()'"
)


def check_compiled(environment: Mapping[str, str]) -> Iterator[Finding]:
    """Look for the machine code that Numba keeps of each room's loops."""
    if environment.get('NUMBA_DISABLE_JIT', '0') != '0':
        yield error(
            'kernels', 'NUMBA_DISABLE_JIT is set: each fit takes a hundred times as long',
            'without it', 'unset NUMBA_DISABLE_JIT',
        )
        return
    try:
        for room in ROOMS:
            import_module(f'blob_tracker.{room}')
    except RuntimeError as fault:  # of Numba, which has looked in several places
        yield error(
            'kernels',
            f'Numba finds no folder that it may write its machine code to ({fault})',
            'name one',
            'export NUMBA_CACHE_DIR=$HOME/.cache/numba',
        )
        return
    except ImportError:
        return  # the check of the libraries has said which
    from blob_tracker.kernel import compiled

    yield judge({room: compiled(f'blob_tracker.{room}') for room in ROOMS})


def judge(compiled: Mapping[str, tuple[int, int, str]]) -> Finding:
    """
    Return the finding.

    Parameters
    ----------
    compiled : mapping
        room -> how many of its loops are compiled for this processor, how many it has, and the
        folder that the machine code is in.

    """
    words = ', '.join(
        f'{room} {done} of {all_}' for room, (done, all_, _) in compiled.items()
    )
    folder = next(iter(compiled.values()))[2]
    if all(done for done, _, _ in compiled.values()):
        return ok('kernels', f'compiled for this processor: {words}, in {folder}')
    return warn(
        'kernels',
        f'compiled for this processor: {words}, in {folder}; a node compiles what it lacks as it '
        'starts, which takes half a minute, once',
        'to do it now',
        COMPILE,
    )
