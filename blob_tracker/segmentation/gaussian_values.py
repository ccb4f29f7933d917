"""Values of a Gaussian at many distances, in the vectors of the processor."""

from __future__ import annotations

from math import factorial, log

from blob_tracker.kernel import Array, kernel
import numpy as np

LN_2, PER_LN_2 = log(2.0), 1.0 / log(2.0)
# Of exp(r) = sum(r^n / n!), the highest power first: for |r| < ln(2) / 2 the rest is below 1e-17.
SERIES = tuple(1.0 / factorial(n) for n in range(13, -1, -1))
FARTHEST2 = 1400.0  # sigma^2: beyond it is nothing that a double can tell from it
BIAS, MANTISSA = 1023, 52  # of a double: what is added to its exponent, and the bits below that


@kernel
def gaussian_values(distances2: Array) -> Array:
    """
    Return exp(-q / 2) of each squared distance q, in sigma^2, to 1e-14.

    It is 2^k exp(r) with k whole and |r| < ln(2) / 2. A call of exp() for each would take longer
    than all else that is done with a pixel.
    """
    size = distances2.size
    out, powers = np.empty(size), np.empty(size, np.int64)
    flat = distances2.ravel()
    for i in range(np.uint64(size)):
        exponent = -0.5 * min(flat[i], FARTHEST2)
        k = np.floor(exponent * PER_LN_2 + 0.5)
        r = exponent - k * LN_2
        value = 0.0
        for term in SERIES:
            value = value * r + term
        out[i] = value
        powers[i] = (np.int64(k) + BIAS) << MANTISSA
    scales = powers.view(np.float64)
    for i in range(np.uint64(size)):
        out[i] *= scales[i]
    return out.reshape(distances2.shape)
