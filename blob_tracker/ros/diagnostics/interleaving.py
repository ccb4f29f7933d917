"""Whether messages of several publishers come in turns, by the numbers that they have."""

from __future__ import annotations

from collections import deque

SILENCE_NS = 10**9  # after it a publisher may be another one, that counts from anew


class Interleaving:
    """
    Tell whether several publishers number the messages.

    Each has numbers of its own, and they go back time and again; those of a publisher that is
    started again do so once.
    """

    def __init__(self) -> None:
        self._last: tuple[int, int] | None = None  # number and time of the last message
        self._backwards: deque[int] = deque(maxlen=2)  # when the numbers went back, ns

    def took(self, number: int, sent_ns: int) -> None:
        """Take note of a message by its publisher's number and the time at which it was sent."""
        if self._last is not None and number <= self._last[0]:
            self._backwards.append(sent_ns)
        self._last = number, sent_ns

    @property
    def mixed(self) -> bool:
        """Whether they went back twice within the last second."""
        if self._last is None or len(self._backwards) < 2:
            return False
        return self._last[1] - self._backwards[0] < SILENCE_NS
