"""Somebody who waits while kernels are compiled is told so, once."""

from __future__ import annotations

from collections.abc import Callable

COMPILING = (
    'compiling the loops over pixels: three to seven minutes the first time, seconds from then on'
)
_WAITING: list[Callable[[str], object]] = []


def before_compiling(tell: Callable[[str], object]) -> None:
    """
    Have a sentence told before the first kernel of this process is compiled, if one is.

    Parameters
    ----------
    tell : callable
        Takes the sentence. Where all machine code is on disk it is never called.

    """
    _WAITING[:] = [tell]


def compiling() -> None:
    """Tell it, unless that was done."""
    while _WAITING:
        _WAITING.pop()(COMPILING)
