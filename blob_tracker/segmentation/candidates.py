"""All that lit up in a frame: a table, of which a `Candidate` is made where one is looked at."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import repeat
from types import MappingProxyType
from typing import overload

from blob_tracker.kernel import Array
from blob_tracker.segmentation.candidate import Candidate
from blob_tracker.segmentation.overexposure import advice
from blob_tracker.segmentation.rejection import FIELDS, GLOW, glow_in_words, in_words
import numpy as np

NONE_CLIPPED: Mapping[int, int] = MappingProxyType({})
UNJUDGED = tuple(Candidate._field_defaults.values())[FIELDS - len(Candidate._fields):]


class Candidates(Sequence[Candidate]):
    """
    What lit up, the highest first; most of it is never looked at by itself.

    Parameters
    ----------
    table : (n, 23) array
        See `measure_peaks`; as `mark_glows` leaves it.
    clipped : mapping of int to int
        How many pixels of those that are over-exposed are clipped, by their rows in the table.

    Attributes
    ----------
    table : (n, 23) array
        That one.

    """

    def __init__(self, table: Array, clipped: Mapping[int, int] = NONE_CLIPPED) -> None:
        self.table = table
        self._clipped = clipped

    @cached_property
    def _all(self) -> tuple[Candidate, ...]:
        *fields, _ = self.table.T.tolist()
        found = list(map(Candidate._make, zip(*fields, *map(repeat, UNJUDGED))))
        for index in np.flatnonzero(self.table[:, FIELDS]).tolist():
            found[index] = self._judged(index, found[index])
        return tuple(found)

    def _judged(self, index: int, one: Candidate) -> Candidate:
        """Return a candidate with the reason why it is no target, if there is one."""
        fault = self.table.item(index, FIELDS)
        if not fault:
            return one
        if fault >= GLOW:
            words = glow_in_words(one, self._unjudged(int(fault) - GLOW))
        else:
            words = in_words(int(fault), one)
        return one._replace(rejected=advice(self._clipped.get(index, 0)) + words)

    def _unjudged(self, index: int) -> Candidate:
        return Candidate(*self.table[index, :FIELDS].tolist())

    def __len__(self) -> int:
        return len(self.table)

    @overload
    def __getitem__(self, index: int) -> Candidate: ...

    @overload
    def __getitem__(self, index: slice) -> Sequence[Candidate]: ...

    def __getitem__(self, index: int | slice) -> Candidate | Sequence[Candidate]:
        if isinstance(index, slice) or '_all' in vars(self):
            return self._all[index]
        index = range(len(self))[index]
        return self._judged(index, self._unjudged(index))

    def __iter__(self) -> Iterator[Candidate]:
        return iter(self._all)


def table_of(candidates: Sequence[Candidate]) -> Array:
    """Return the (n, 23) table of candidates: their fields, and other than 0 what is rejected."""
    if isinstance(candidates, Candidates):
        return candidates.table
    rows = [(*each[:FIELDS], bool(each.rejected)) for each in candidates]
    return np.array(rows, float).reshape(-1, FIELDS + 1)
