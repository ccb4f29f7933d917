"""What a check has found."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Level(Enum):
    """How bad it is."""

    OK = 'OK'
    WARN = 'WARN'  # the nodes run, but not as well as they could
    ERROR = 'ERROR'  # something does not work


@dataclass(frozen=True)
class Finding:
    """
    One finding.

    Parameters
    ----------
    level : Level
        How bad it is.
    subject : str
        What was looked at.
    message : str
        How it is, and where it is not right, what would be.
    advice : str
        What to do, in words.
    command : str
        What to type.

    """

    level: Level
    subject: str
    message: str
    advice: str = ''
    command: str = ''


def ok(subject: str, message: str) -> Finding:
    """Return a finding that all is well."""
    return Finding(Level.OK, subject, message)


def warn(subject: str, message: str, advice: str = '', command: str = '') -> Finding:
    """Return a finding that could be better."""
    return Finding(Level.WARN, subject, message, advice, command)


def error(subject: str, message: str, advice: str = '', command: str = '') -> Finding:
    """Return a finding that something does not work."""
    return Finding(Level.ERROR, subject, message, advice, command)
