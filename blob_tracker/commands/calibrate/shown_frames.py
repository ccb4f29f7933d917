"""The frames of a calibration's source, with a progress bar; a topic's end on Ctrl-C."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
import signal

from blob_tracker.commands.calibrate.sources import expected, is_live, stamped_frames
from blob_tracker.types import Pixels
from rich.console import Console
from rich.progress import track

StampedFrame = tuple[str, 'float | None', Pixels]


def shown_frames(
    arguments: argparse.Namespace,
    console: Console,
    doing: str,
    *,
    live_frames: int | None = None,
    live_seconds: float | None = None,
    interpolate: bool = True,
    woven: bool = False,
) -> Iterator[StampedFrame]:
    """
    Yield the frames of SOURCE.

    Parameters
    ----------
    arguments : Namespace
        Of a parser that `add_source` filled.
    console : Console
        Shows the progress.
    doing : str
        What is done with the frames.
    live_frames : int, optional
        So many are taken of a topic, which does not end by itself, where neither --count nor
        --seconds is given.
    live_seconds : float, optional
        The same as a time, s.
    interpolate : bool
        As in `frames`.
    woven : bool
        As in `stamped_frames`.

    Yields
    ------
    str, float or None, (h, w) uint8 or uint16 array
        What `stamped_frames` does.

    Raises
    ------
    SourceError
        As `frames` does.
    KeyboardInterrupt
        On Ctrl-C; of a topic on the second one, as the first ends the listening.

    """
    live = is_live(arguments)
    if live and arguments.seconds is None and arguments.count is None:
        arguments.count, arguments.seconds = live_frames, live_seconds
    stream = stamped_frames(arguments, interpolate=interpolate, woven=woven)
    if live:
        limits = [f'{arguments.seconds:g} s'] if arguments.seconds else []
        limits += [f'{arguments.count} frames'] if arguments.count else []
        console.print(
            f'Listening to {arguments.source} for {" or ".join(limits)}; Ctrl-C ends it earlier, '
            'and what came by then is measured.', highlight=False,
        )
        stream = _until_interrupt(stream)
    yield from track(stream, doing, expected(arguments), console=console, transient=True)


def _until_interrupt(stream: Iterator[StampedFrame]) -> Iterator[StampedFrame]:
    """
    Yield what a stream has until Ctrl-C; a second one is Python's again.

    While a frame is waited for, it ends the waiting; work on one that came is finished first.
    """
    ended = waiting = False
    before = signal.getsignal(signal.SIGINT)

    def end(*_: object) -> None:
        nonlocal ended
        ended = True
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
