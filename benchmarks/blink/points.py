"""Points as a detector would find them, without pixels: for the filter by itself."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.blink.lights import Floats, HEIGHT, Truth, WIDTH
import numpy as np

SIGMA = 1.5  # px
PEAK, NOISE = 100.0, 1.0  # DN
FULL_FLUX = 2 * np.pi * SIGMA**2 * PEAK  # DN px^2
LEAST_SHARE = 0.05  # of a light that is found


def points(
    seen: Sequence[Truth | None], hidden: Sequence[bool], clutter: int,
    random: np.random.Generator,
) -> tuple[Floats, list[int]]:
    """
    Return the (n, 7) points of a frame, see `BlinkTracker.update`, and whose they are.

    Lights closer than 2 sigma melt into one. Clutter has any share of the full flux; its owner
    is -1.
    """
    rows: list[list[float]] = []
    owners: list[int] = []
    for index, (each, away) in enumerate(zip(seen, hidden)):
        if each is None or away or each.share < LEAST_SHARE:
            continue
        spread = (0.02 + 0.02 / each.share) ** 2
        covariance = spread * (np.eye(2) + each.covariance / SIGMA**2)
        place = random.multivariate_normal([each.x, each.y], covariance)
        flux_sigma = NOISE * np.sqrt(4 * np.pi) * SIGMA
        flux = each.share * FULL_FLUX + flux_sigma * random.standard_normal()
        near = [
            k for k, row in enumerate(rows)
            if np.hypot(row[0] - place[0], row[1] - place[1]) < 2 * SIGMA
        ]
        if near:
            row = rows[near[0]]
            part = flux / (flux + row[5])
            row[0] += part * (place[0] - row[0])
            row[1] += part * (place[1] - row[1])
            row[5] += flux
            continue
        rows.append([
            *place, covariance[0, 0], covariance[0, 1], covariance[1, 1], flux, flux_sigma,
        ])
        owners.append(index)
    for _ in range(clutter):
        x, y = random.uniform([0, 0], [WIDTH, HEIGHT])
        flux = random.uniform(LEAST_SHARE, 1.0) * FULL_FLUX
        rows.append([x, y, 0.002, 0.0, 0.002, flux, NOISE * np.sqrt(4 * np.pi) * SIGMA])
        owners.append(-1)
    order = random.permutation(len(rows))
    table = np.array(rows).reshape(-1, 7)[order]
    return table, [owners[k] for k in order]
