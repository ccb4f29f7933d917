"""What ends a command, as its exit code and on stderr."""

from __future__ import annotations

from blob_tracker.commands.exit_code import exit_code, UsageError
import pytest


def fail(error: BaseException) -> int:
    """Raise an error."""
    raise error


@pytest.mark.parametrize(
    ('error', 'code', 'said'),
    [
        (KeyboardInterrupt(), 130, ''),
        (UsageError('set it to 3'), 2, 'set it to 3\n'),
        (LookupError('there is no light'), 1, 'there is no light\n'),
        (FileNotFoundError(2, 'No such file', 'a.csv'), 1, 'a.csv: No such file\n'),
        (OSError('the disk is full'), 1, 'the disk is full\n'),
    ],
)
def test_an_error_is_a_sentence_and_a_code(
    error: BaseException, code: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing else is said."""
    assert exit_code(lambda: fail(error), (LookupError,)) == code
    assert capsys.readouterr() == ('', said)


def test_what_is_done_has_its_own_code() -> None:
    """Or 0; what nobody foresaw is raised."""
    assert exit_code(lambda: None, ()) == 0
    assert exit_code(lambda: 3, ()) == 3
    with pytest.raises(ZeroDivisionError):
        exit_code(lambda: fail(ZeroDivisionError()), (LookupError,))
