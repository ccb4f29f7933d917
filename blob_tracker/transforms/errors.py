"""What the room refuses, and says why."""

from __future__ import annotations


class TransformError(ValueError):
    """A transform that cannot be used; the message says why."""


class NoTransform(LookupError):
    """
    A transform that is not known; the message says why.

    Parameters
    ----------
    reason : str
        The message.
    may_come : bool
        Whether to wait helps: it is that of an instant after the newest, or of frames that nothing
        connects so far.
    frame : str
        Of which the transforms are of another time; empty if they are not.
    apart_ns : int
        By how much, ns.

    """

    def __init__(
        self, reason: str, *, may_come: bool = False, frame: str = '', apart_ns: int = 0
    ) -> None:
        super().__init__(reason)
        self.may_come, self.frame, self.apart_ns = may_come, frame, apart_ns
