"""The normal equations of a fit, solved by Cholesky without an allocation."""

from __future__ import annotations

import math
from typing import NamedTuple

from blob_tracker.kernel import Array, kernel
import numpy as np

LARGEST = 6  # parameters


class NormalEquations(NamedTuple):
    """
    M x = right, of which a fit uses the first rows; all of it memory to be used again.

    Parameters
    ----------
    matrix : (6, 6) array
        M, its lower triangle: the Fisher information.
    right : (6,) array
        The score.
    factor : (6, 6) array
        Cholesky factor L of the matrix that was solved last.
    solution : (6,) array
        The step.

    """

    matrix: Array
    right: Array
    factor: Array
    solution: Array


@kernel
def empty_equations() -> NormalEquations:
    """Return the memory for them."""
    return NormalEquations(
        np.empty((LARGEST, LARGEST)), np.empty(LARGEST), np.empty((LARGEST, LARGEST)),
        np.empty(LARGEST),
    )


@kernel
def solve(equations: NormalEquations, size: int, damping: float) -> bool:
    """
    Solve the first `size` equations, (M + damping diag M) x = right; False where M is singular.

    `factor` and `solution` are filled (Cholesky: M = L L^T).
    """
    matrix, right, factor, solution = equations
    for p in range(size):
        for q in range(p + 1):
            total = matrix[p, q]
            if p == q:
                total *= 1.0 + damping
            for k in range(q):
                total -= factor[p, k] * factor[q, k]
            if p == q:
                # A pivot of 1e-10 of its diagonal is what rounding leaves of a zero.
                if not total > 1e-10 * matrix[p, p]:
                    return False
                factor[p, p] = math.sqrt(total)
            else:
                factor[p, q] = total / factor[q, q]
    for p in range(size):
        total = right[p]
        for k in range(p):
            total -= factor[p, k] * solution[k]
        solution[p] = total / factor[p, p]
    _back_substitute(factor, size, solution)
    return True


@kernel
def _back_substitute(factor: Array, size: int, solution: Array) -> None:
    """Solve L^T x = solution in place."""
    for p in range(size - 1, -1, -1):
        total = solution[p]
        for k in range(p + 1, size):
            total -= factor[k, p] * solution[k]
        solution[p] = total / factor[p, p]


@kernel
def column_of_inverse(equations: NormalEquations, size: int, column: int) -> None:
    """Fill `solution` with a column of the inverse of the matrix that was solved last."""
    factor, out = equations.factor, equations.solution
    for p in range(size):
        total = 1.0 if p == column else 0.0
        for k in range(p):
            total -= factor[p, k] * out[k]
        out[p] = total / factor[p, p]
    _back_substitute(factor, size, out)
