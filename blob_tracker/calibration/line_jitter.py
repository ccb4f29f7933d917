"""The horizontal offset of each line of an analogue grabber, from pictures of a vertical edge."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from blob_tracker.calibration.edge import edge_places, EdgeError, find_edge
from blob_tracker.camera.line_jitter import LineJitter
import numpy as np
from numpy.typing import NDArray

LEAST_FRAMES = 4
LEAST_LINES = 8
OUTLIER = 5.0  # standard deviations: beyond it a line of a frame lost its synchronisation
MARK = 0.5  # px off the lines beside it: jitter is smooth to a tenth of that, a mark is not
NEIGHBOURS = 7  # lines of the field whose median stands for its neighbourhood
ROUNDS = 4


@dataclass(frozen=True)
class LineJitterMeasurement:
    """
    Line jitter and what it was had from.

    Parameters
    ----------
    jitter : LineJitter
        Offsets, their sigmas and the jitter from frame to frame, px.
    measured : (h,) bool array
        False where a line was interpolated from its field.
    places : (n, h) array
        x of the edge in each line of each frame, px; NaN if there is none.
    edge_sigma : float
        Blur of the edge, px.
    edge : (float, float)
        Straight edge that was taken off: x in line 0, px, and its slope, px per line.
    noise : float
        What the pixels' noise adds to the place of an edge in one frame, rms, px.
    between_neighbours : float
        Correlation of the jitter of neighbouring lines of a field; LineJitter takes it as 0.
    fields : int
        2 where the lines are of two fields in turn, 1 where they are not.

    Examples
    --------
    How far the lines of a grabber come to lie from frame to frame, as the edge says:

    >>> from blob_tracker.simulation.line_jitter import draw_edge
    >>> random = np.random.default_rng(1)
    >>> frames = [
    ...     draw_edge((80, 64), random.normal(32.0, 0.05, 80), 1.1, 30.0, 200.0) for _ in range(6)
    ... ]
    >>> found = measure_line_jitter(random.normal(frames, 2.0), fields=1)
    >>> found.places.shape
    (6, 80)
    >>> round(found.jitter.sigma_from_frame_to_frame, 2), round(found.edge_sigma, 1)  # px
    (0.05, 1.1)

    """

    jitter: LineJitter
    measured: NDArray[np.bool_]
    places: NDArray[np.float64]
    edge_sigma: float
    edge: tuple[float, float]
    noise: float
    between_neighbours: float
    fields: int


def measure_line_jitter(
    frames: Iterable[NDArray[np.generic]], *, fields: int = 2
) -> LineJitterMeasurement:
    """
    Measure the offset of each line from frames of one still, straight, nearly vertical edge.

    In each line k of each field i, which is the whole frame where the lines are not those of two
    fields, the edge is placed to a fraction of a pixel (`edge_places`):

        x_ik = offset_k + edge_0 + slope k + shift_i + tilt_i k + jitter_ik + noise_ik

    shift_i and tilt_i, the camera's own trembling, are taken off by a straight line for each
    field, as the two of a picture are exposed one after the other; the mean over the frames, less
    its straight line, is the offset. What the trembling leaves in the mean distance of the two
    fields has a sigma of its own. A straight line over the whole picture cannot be told from the
    inclination of the edge; it belongs to the camera matrix. Lines of a frame beyond 5 standard
    deviations are left out; lines that stay out are interpolated in their field. The scatter
    beyond the noise of the fits is the jitter from frame to frame.

    Parameters
    ----------
    frames : iterable of (h, w) arrays
        DN, 4 or more.
    fields : int
        2 for interlaced pictures, 1 for progressive ones.

    Returns
    -------
    LineJitterMeasurement
        The offsets and what they were had from.

    Raises
    ------
    EdgeError
        If there are too few frames, they differ in size, or there is no vertical edge.

    Examples
    --------
    A grabber that shifts every other line by 0.2 px, before a leaning edge:

    >>> from blob_tracker.simulation.line_jitter import draw_edge
    >>> lines, random = np.arange(80), np.random.default_rng(1)
    >>> places = 30.0 + 0.03 * lines + 0.2 * (lines % 2)  # px
    >>> frames = [
    ...     random.normal(draw_edge((80, 64), places, 1.1, 30.0, 200.0), 2.0) for _ in range(6)
    ... ]
    >>> found = measure_line_jitter(frames)
    >>> round(float(np.diff(found.jitter.offsets)[::2].mean()), 2)  # px
    0.2

    """
    found: list[NDArray[np.float64]] = []
    variances: list[NDArray[np.float64]] = []
    widths: list[float] = []
    for frame in frames:
        pixels = np.asarray(frame, dtype=float)
        if not found:
            edges = [find_edge(pixels[field::fields]) for field in range(fields)]
            shape = pixels.shape
        if pixels.shape != shape:
            raise EdgeError(
                f'frame {len(found) + 1} is {pixels.shape[1]} x {pixels.shape[0]} px and the '
                f'first {shape[1]} x {shape[0]} px; they must be of one camera'
            )
        found.append(np.empty(shape[0]))
        variances.append(np.empty(shape[0]))
        widths = []
        for field, edge in enumerate(edges):
            part = slice(field, None, fields)
            found[-1][part], variances[-1][part], width = edge_places(pixels[part], edge)
            widths.append(width)
    if len(found) < LEAST_FRAMES:
        raise EdgeError(f'there are {len(found)} frames; line jitter needs {LEAST_FRAMES} or more')
    places, variance = np.array(found), np.array(variances)
    offsets, residuals, shifts = _separate(places, fields)
    # A field's straight line and a line's mean took away degrees of freedom from the residuals.
    used = np.isfinite(residuals)
    counts = used.sum(axis=0)
    measured = (counts >= max(2, len(found) // 2)) & _unmarked(offsets, fields)
    if measured.sum() < LEAST_LINES:
        raise EdgeError(
            f'the edge is seen in {measured.sum()} lines only; it must run from top to bottom'
        )
    used &= measured
    freedom = used.sum() - measured.sum() - 2 * fields * (len(found) - 1)
    noise = float(variance[used].mean())
    scatter = float((residuals[used] ** 2).sum() / freedom)
    jitter = float(np.sqrt(max(scatter - noise, 0.0)))
    with np.errstate(divide='ignore', invalid='ignore'):
        own = np.where(used, variance, 0.0).sum(axis=0) / counts
        # Where there is no jitter the difference is either side of 0: its mean must stay so.
        sigma = np.sqrt(np.maximum(scatter - noise + own, 0.25 * own) / counts)
    lines = np.arange(len(offsets))
    slope, start = np.polyfit(lines[measured], offsets[measured], 1)
    offsets = offsets - start - slope * lines
    offsets, sigma = _interpolated(offsets, sigma, measured, fields)
    apart = shifts[:, -1] - shifts[:, 0]  # of one field with itself: 0
    return LineJitterMeasurement(
        jitter=LineJitter(
            offsets, sigma, jitter, float(apart.std(ddof=1) / np.sqrt(len(apart)))
        ),
        measured=measured,
        places=places,
        edge_sigma=float(np.mean(widths)),
        edge=(float(start), float(slope)),
        noise=float(np.sqrt(noise)),
        between_neighbours=_between_neighbours(residuals, scatter - noise, fields),
        fields=fields,
    )


def _separate(
    places: NDArray[np.float64], fields: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """
    Part the places from frame to frame from what they have in common.

    Returns
    -------
    mean : (h,) array
        Over the frames, px.
    rest : (n, h) array
        px; NaN where it is out of all bounds.
    shifts : (n, fields) array
        Of each field as a whole from its mean, px.

    """
    places = places.copy()
    lines = np.linspace(-1.0, 1.0, places.shape[1])
    mean = _mean(places)
    for _ in range(ROUNDS):
        residuals = places - mean
        shifts = np.zeros((len(places), fields))
        for residual, shift in zip(residuals, shifts):
            for field in range(fields):
                part = slice(field, None, fields)
                seen = np.isfinite(residual[part])
                if seen.sum() > 2:
                    line = np.polyfit(lines[part][seen], residual[part][seen], 1)
                    residual[part] -= np.polyval(line, lines[part])
                    shift[field] = line[1]
        seen = np.isfinite(residuals)
        if not seen.any():
            break
        deviation = 1.4826 * np.median(np.abs(residuals[seen]))  # of a normal distribution
        out = np.abs(np.where(seen, residuals, 0.0)) > OUTLIER * max(deviation, 1e-9)
        places[out] = residuals[out] = np.nan
        mean = mean + _mean(residuals)
    return mean, residuals - _mean(residuals), shifts


def _mean(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean of each column without its NaN; NaN where that is all."""
    seen = np.isfinite(values)
    counts = seen.sum(axis=0)
    sums = np.where(seen, values, 0.0).sum(axis=0)
    return np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)


def _unmarked(offsets: NDArray[np.float64], fields: int) -> NDArray[np.bool_]:
    """Return where a line lies among its neighbours of the field: no dust, no notch."""
    smooth = np.isfinite(offsets)
    for field in range(fields):
        values = offsets[field::fields]
        seen = np.flatnonzero(np.isfinite(values))
        if not len(seen):
            continue
        padded = np.pad(values[seen], NEIGHBOURS // 2, mode='reflect', reflect_type='odd')
        near = np.lib.stride_tricks.sliding_window_view(padded, NEIGHBOURS)
        marked = np.abs(values[seen] - np.median(near, axis=1)) > MARK
        smooth[field + fields * seen[marked]] = False
    return smooth


def _interpolated(
    offsets: NDArray[np.float64],
    sigma: NDArray[np.float64],
    measured: NDArray[np.bool_],
    fields: int,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fill lines that were not measured from those of their field, and say how well."""
    offsets, sigma = offsets.copy(), sigma.copy()
    for field in range(fields):
        part = slice(field, None, fields)
        seen = np.flatnonzero(measured[part])
        if not len(seen):
            raise EdgeError('a whole field shows no edge; is the picture progressive?')
        values, spread = offsets[part][seen], sigma[part][seen]
        missing = np.flatnonzero(~measured[part])
        offsets[part][missing] = np.interp(missing, seen, values)
        # How far a line is from the one before it is how far one may be from its neighbours.
        step = float(np.sqrt(np.mean(np.diff(values) ** 2))) if len(values) > 1 else 0.0
        distance = np.abs(missing[:, None] - seen).min(axis=1, initial=len(offsets))
        sigma[part][missing] = np.sqrt(np.median(spread) ** 2 + distance * step**2)
    return offsets, sigma


def _between_neighbours(residuals: NDArray[np.float64], variance: float, fields: int) -> float:
    """Return the correlation of the jitter of neighbouring lines of a field."""
    products = residuals[:, fields:] * residuals[:, :-fields]
    products = products[np.isfinite(products)]
    if variance <= 0.0 or not len(products):
        return 0.0
    return float(np.clip(products.mean() / variance, -1.0, 1.0))
