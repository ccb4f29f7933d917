"""The frames of a source, with a progress bar; Ctrl-C ends what would not end by itself."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator
import signal
from typing import TypeVar

from blob_tracker.commands.sources import (
    grey_frames, GreyFrame, is_live, open_source, Source,
)
from blob_tracker.commands.sources.response import response_of
from rich.console import Console
from rich.progress import track

Each = TypeVar('Each')


def shown_frames(
    arguments: argparse.Namespace,
    console: Console,
    doing: str,
    *,
    live_frames: int | None = None,
    live_seconds: float | None = None,
    interpolate: bool = True,
    woven: bool = False,
) -> Iterator[GreyFrame]:
    """
    Yield the frames of SOURCE without their colours.

    Parameters
    ----------
    arguments : Namespace
        Of a parser that `add_source` filled.
    console : Console
        Shows the progress.
    doing : str
        What is done with the frames.
    live_frames : int, optional
        So many are taken of a camera or a topic, which do not end by themselves, where neither
        --count nor --seconds is given.
    live_seconds : float, optional
        The same as a time, s.
    interpolate : bool
        As in `grey_frames`.
    woven : bool
        As in `open_source`.

    Yields
    ------
    GreyFrame
        What `grey_frames` does.

    Raises
    ------
    SourceError
        As `open_source` does.
    KeyboardInterrupt
        On Ctrl-C; of a live source on the second one, as the first ends the listening.

    """
    if is_live(arguments) and arguments.seconds is None and arguments.count is None:
        arguments.count, arguments.seconds = live_frames, live_seconds
    source = open_source(arguments, woven=woven)
    stream = grey_frames(source, interpolate=interpolate, response=response_of(arguments))
    if is_live(arguments):
        console.print(
            f'Listening to {arguments.source} for {in_words(arguments)}; Ctrl-C ends it earlier, '
            'and what came by then is measured.', highlight=False,
        )
        stream = until_interrupt(stream)
    yield from with_bar(stream, source, arguments, console, doing)


def with_bar(
    stream: Iterable[Each], source: Source, arguments: argparse.Namespace, console: Console,
    doing: str,
) -> Iterator[Each]:
    """Yield a stream of frames of a source, with a progress bar."""
    count = arguments.count if source.count is None else source.count
    yield from track(stream, doing, count, console=console, transient=True)


def in_words(arguments: argparse.Namespace) -> str:
    """Return for how long a live source is listened to."""
    limits = [f'{arguments.seconds:g} s'] if arguments.seconds else []
    limits += [f'{arguments.count} frames'] if arguments.count else []
    return ' or '.join(limits)


def until_interrupt(
    stream: Iterator[Each], interrupted: Callable[[], None] = lambda: None
) -> Iterator[Each]:
    """
    Yield what a stream has until Ctrl-C, which is told; a second one is Python's again.

    While a frame is waited for, it ends the waiting; work on one that came is finished first.
    """
    ended = waiting = False
    before = signal.getsignal(signal.SIGINT)

    def end(*_: object) -> None:
        nonlocal ended
        ended = True
        interrupted()
        signal.signal(signal.SIGINT, before)
        if waiting:
            raise KeyboardInterrupt

    signal.signal(signal.SIGINT, end)
    try:
        while not ended:
            try:
                waiting = True
                each = next(stream)
                waiting = False
            except (KeyboardInterrupt, StopIteration):
                return
            yield each
    finally:
        signal.signal(signal.SIGINT, before)
