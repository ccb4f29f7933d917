"""A topic is listened to until Ctrl-C, and what came by then is measured."""

from __future__ import annotations

from collections.abc import Iterator
from signal import default_int_handler, getsignal, raise_signal, SIGINT

from blob_tracker.commands.sources.shown_frames import until_interrupt
import pytest


def test_the_first_ctrl_c_ends_a_stream_wherever_it_comes() -> None:
    """While a frame is waited for, or worked on; the second is Python's again."""
    def waits() -> Iterator[str]:
        yield '1'
        raise_signal(SIGINT)
        yield '2'

    assert list(until_interrupt(waits())) == ['1']
    worked = []
    for name in until_interrupt(str(each) for each in range(9)):
        if name == '2':
            raise_signal(SIGINT)
            with pytest.raises(KeyboardInterrupt):
                raise_signal(SIGINT)
        worked.append(name)
    assert worked == ['0', '1', '2']
    assert getsignal(SIGINT) is default_int_handler
