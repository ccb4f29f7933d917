"""What a target is decided by: the worst of some rows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

Limit = tuple[str, float, float, bool, str, str]
Row = TypeVar('Row', bound=Any)


def worst(
    name: str, limit: float, rows: Sequence[Row], figure: Callable[[Row], float],
    floor: bool = False, unit: str = '',
) -> Limit:
    """Return name, limit, figure, whether it is a floor, unit and case of the worst row."""
    row = (min if floor else max)(rows, key=figure)
    return name, limit, figure(row), floor, unit, row.case.name
