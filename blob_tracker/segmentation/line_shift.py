"""Whether a light in both frames of a pair is shared between them line by line."""

from __future__ import annotations

from collections import deque
import math

import numpy as np
from numpy.typing import NDArray

# Flashes over which a shift between the lit and the unlit frame is measured, and those it takes.
MOST_SHIFTS, LEAST_SHIFTS = 48, 12
CHECKED = 6  # flashes from one look at them to the next
LEAST_T = 5.0  # of its standard deviations, from which on it is one


class LineShift:
    """
    Tell whether a light that is in both frames of a pair stands higher in the one.

    So it does if it is switched while its lines are read one after the other: the one frame has
    its upper lines, the other its lower ones.

    Attributes
    ----------
    seen : bool
        Whether there is a shift that neither its speed nor the bend of its path explains.
    judged : bool
        Whether enough flashes were seen to tell.

    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Know nothing of the light."""
        self._places: deque[float] = deque(maxlen=3)  # of the last lit frames, px
        self._rows: deque[tuple[float, float, float]] = deque(maxlen=MOST_SHIFTS)
        self._count = 0
        self.seen = self.judged = False

    def add(self, lit_y: float, unlit_y: float | None) -> None:
        """Take where it is in a lit frame and in the unlit one before, px; None if it is not."""
        self._places.append(lit_y)
        if unlit_y is None or len(self._places) < 3:
            return
        first, second, last = self._places
        self._rows.append((last - second, last - 2.0 * second + first, unlit_y - last))
        self._count += 1
        if self._count >= LEAST_SHIFTS and self._count % CHECKED == 0:
            self.judged = True
            self.seen = _is_shifted(np.array(self._rows))


def _is_shifted(rows: NDArray[np.float64]) -> bool:
    """Tell whether the last column has a mean that the others, speed and bend, do not explain."""
    design = np.column_stack([np.ones(len(rows)), rows[:, :2]])
    parts, _, rank, _ = np.linalg.lstsq(design, rows[:, 2], rcond=1e-6)
    if rank < 3:
        return False
    left = rows[:, 2] - design @ parts
    variance = float(left @ left) / (len(rows) - 3) * np.linalg.inv(design.T @ design)[0, 0]
    return bool(abs(parts[0]) > LEAST_T * math.sqrt(variance))
