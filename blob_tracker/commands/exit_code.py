"""How a command ends: what went wrong becomes a sentence and an exit code."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
import sys

FAILED, CALLED_WRONGLY = 1, 2
INTERRUPTED = 130  # as of a shell command that Ctrl-C ended


class UsageError(ValueError):
    """An option that is wrong whatever the source holds; the message says what would be right."""


def check_out(out: Path, suffix: str, *inputs: Path | None) -> None:
    """
    Refuse a file that results should not go to.

    Parameters
    ----------
    out : Path
        The file.
    suffix : str
        That of the picture which is written beside it; '' where that has another name anyway.
    inputs : Path or None
        What is read, and must not be lost.

    Raises
    ------
    UsageError
        It is the picture's or an input's name, or there is no such folder.

    """
    if not out.parent.is_dir():
        raise UsageError(f'--out {out}: {out.parent} is not a folder; make it first')
    if suffix and out.suffix.lower() == suffix:
        yaml = out.with_suffix('.yaml')
        raise UsageError(
            f'--out {out} is the name of the picture beside it; name the file, {yaml} say'
        )
    for path in inputs:
        if path is not None and path.resolve() == out.resolve():
            raise UsageError(f'--out {out} is what is read; give it another name')


def exit_code(
    work: Callable[[], int | None],
    failures: tuple[type[Exception], ...],
    misuses: tuple[type[Exception], ...] = (UsageError,),
) -> int:
    """
    Do the work of a command; say on stderr what ends it.

    Parameters
    ----------
    work : callable
        Returns its own exit code, or None if it is done.
    failures, misuses : tuple of exception types
        Errors whose message is the sentence: of a source, and of how the command was called.

    Returns
    -------
    int
        0 done, 1 failed, 2 called wrongly, 130 after Ctrl-C.

    """
    try:
        return work() or 0
    except KeyboardInterrupt:
        return INTERRUPTED
    except misuses as error:
        print(error, file=sys.stderr)
        return CALLED_WRONGLY
    except failures as error:
        print(error, file=sys.stderr)
    except OSError as error:
        print(f'{error.filename}: {error.strerror}' if error.filename else error, file=sys.stderr)
    return FAILED
