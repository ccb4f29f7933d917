"""The parser of the commands: it says what a misspelt option or a wrong number should be."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from difflib import get_close_matches
from typing import Any


class Parser(argparse.ArgumentParser):
    """An ArgumentParser whose subparsers refuse what they do not know, with their own usage."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.register('type', float, number)
        self.register('type', int, whole_number)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Return the values, and nothing that is unknown: that ends the program."""
        found, left = super().parse_known_args(args, namespace)
        if left:
            self.error(_unknown(left, list(self._option_string_actions)))
        return found, left


def number(word: str) -> float:
    """Return the number that a word of the command line is."""
    try:
        return float(word)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"'{word}' is not a number; write 12.5 say, without a unit: --help names it"
        ) from None


def whole_number(word: str) -> int:
    """Return the whole number that a word of the command line is."""
    try:
        return int(word)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"'{word}' is not a whole number; write 12 say, without a unit: --help names it"
        ) from None


def _unknown(words: Sequence[str], options: Sequence[str]) -> str:
    """Return what is said of words that a command does not know."""
    said = f'unrecognized arguments: {" ".join(words)}'
    misspelt = [word.partition('=')[0] for word in words if word.startswith('-')]
    near = [name for word in misspelt for name in get_close_matches(word, options, n=1)]
    if near:
        return f'{said}; did you mean {" and ".join(near)}?'
    return f'{said}; --help lists the options' if misspelt else said
