"""Normal deviates drawn once and used over and over: noise at the price of a multiplication."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

COUNT = 1 << 23  # 32 MB; a frame starts anywhere in it, so that two are hardly ever alike


class NoiseBank:
    """
    A source of normal deviates for `expose`: a stretch of the bank, from a random start.

    Within a frame no deviate comes twice. Between two frames of n pixels the noise is the same
    field, shifted, with the probability 2 n / COUNT, and within a blob's width of each other once
    in 10^5 pairs.

    Parameters
    ----------
    seed, index : int
        Of the scene and of the frame: they give the start.

    """

    def __init__(self, seed: int, index: int) -> None:
        self._random = np.random.Generator(np.random.SFC64([seed, index]))

    def standard_normal(
        self, shape: tuple[int, ...], dtype: type[np.float32] = np.float32
    ) -> NDArray[np.float32]:
        """Return deviates of mean 0 and variance 1, which may be read-only."""
        size = int(np.prod(shape))
        if size > COUNT // 2:  # frames would be alike, or do not fit: these are drawn again
            return self._random.standard_normal(shape, dtype)
        start = int(self._random.integers(COUNT - size + 1))
        return _bank()[start:start + size].reshape(shape).astype(dtype, copy=False)


@lru_cache(maxsize=1)
def _bank() -> NDArray[np.float32]:
    """Return the deviates, the same in every process."""
    random = np.random.Generator(np.random.SFC64(20))
    deviates = random.standard_normal(COUNT, dtype=np.float32)
    deviates.flags.writeable = False
    return deviates
