"""The pages of a TIFF, an OME-TIFF or a stack of ImageJ, by tifffile."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import prod
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from blob_tracker.commands.sources.source import (
    frame_of, library, Source, SourceError, SourceFrame,
)
import numpy as np
from numpy.typing import NDArray

SUFFIXES = ('.tif', '.tiff')
PICTURES = ('YX', 'YXS')  # the axes of one of them: rows, columns, samples
_SECONDS = {'s': 1.0, 'ms': 1e-3, '\u00b5s': 1e-6, 'us': 1e-6, 'ns': 1e-9, 'min': 60.0}


def open_tiff(path: Path) -> Source:
    """
    Open a file of one or more pages, each of them a frame.

    Raises
    ------
    SourceError
        It cannot be read, or has more axes than time, rows and columns.

    """
    tifffile = library('tifffile', 'TIFF files')
    try:
        file = tifffile.TiffFile(path)
        series = file.series
    except (OSError, ValueError, tifffile.TiffFileError) as error:
        raise SourceError(f'{path} is not a TIFF that can be read: {error}') from None
    count = _count(path, series)
    stamps, source = _stamps(file, count)
    return Source(_frames(path, file, stamps), count, source)


def _count(path: Path, series: Sequence[Any]) -> int:
    """Return the number of frames; refuse what is no succession of them."""
    if len(series) != 1:
        sizes = ', '.join(' x '.join(map(str, each.shape)) for each in series[:4])
        raise SourceError(
            f'{path} holds {len(series)} series of pictures ({sizes}); save the frames as one, '
            'all of one size and depth'
        )
    axes, shape = series[0].axes, series[0].shape
    picture = next((each for each in PICTURES if axes.endswith(each)), '')
    leading = {
        axis: size for axis, size in zip(axes, shape[:len(axes) - len(picture)]) if size > 1
    }
    if not picture or len(leading) > 1 or 'C' in leading:
        sizes = ', '.join(f'{axis} {size}' for axis, size in zip(axes, shape))
        raise SourceError(
            f'{path} has the axes {sizes}; a succession of frames has one besides rows Y and '
            'columns X: save one channel and one plane over time'
        )
    return prod(leading.values())


def _frames(path: Path, file: Any, stamps: Sequence[int | None]) -> Iterator[SourceFrame]:
    """Yield the pages in their order, each read when its turn comes."""
    with file:
        try:
            for index, pixels in enumerate(_pictures(file.series[0], len(stamps))):
                yield frame_of(pixels, f'{path.name} page {index + 1}', stamps[index])
        except (ValueError, OSError) as error:
            if isinstance(error, SourceError):
                raise
            # Without imagecodecs tifffile does not read what is compressed as JPEG, LZW ...
            raise SourceError(f'{path}: {error}') from None


def _pictures(series: Any, count: int) -> Iterator[NDArray[Any]]:
    """Yield the pictures of a series; ImageJ puts large stacks behind a single page."""
    if len(series.pages) == count:
        for page in series.pages:
            yield page.asarray()
        return
    length = 3 if series.axes.endswith('YXS') else 2
    whole = series.asarray(out='memmap') if series.dataoffset is not None else series.asarray()
    yield from whole.reshape(-1, *series.shape[len(series.shape) - length:])


def _stamps(file: Any, count: int) -> tuple[list[int | None], str]:
    """Return the stamps of the pages, ns, and where they are from."""
    none: list[int | None] = [None] * count
    if file.is_ome:
        return _of_ome(file.ome_metadata, count) or (none, '')
    interval = float((file.imagej_metadata or {}).get('finterval', 0.0)) if file.is_imagej else 0.0
    if interval > 0.0:
        return _evenly(interval, count), f"ImageJ's header, {1.0 / interval:g} Hz"
    return none, ''


def _of_ome(xml: str, count: int) -> tuple[list[int | None], str] | None:
    """Return what the metadata tell: the time of each plane, else the time between two."""
    pixels = ElementTree.fromstring(xml).find('.//{*}Pixels')
    if pixels is None:
        return None
    planes = [plane for plane in pixels.findall('{*}Plane') if 'DeltaT' in plane.attrib]
    planes.sort(key=lambda plane: (int(plane.attrib['TheT']), int(plane.attrib['TheZ'])))
    times = [
        float(plane.attrib['DeltaT']) * _SECONDS.get(plane.attrib.get('DeltaTUnit', 's'), np.nan)
        for plane in planes
    ]
    if len(times) == count and np.isfinite(times).all() and (np.diff(times) > 0.0).all():
        return [round(1e9 * each) for each in times], 'DeltaT of the OME header'
    unit = _SECONDS.get(pixels.attrib.get('TimeIncrementUnit', 's'), np.nan)
    interval = float(pixels.attrib.get('TimeIncrement', 0.0)) * unit
    if interval > 0.0:
        return _evenly(interval, count), f'the OME header, {1.0 / interval:g} Hz'
    return None


def _evenly(interval: float, count: int) -> list[int | None]:
    return [round(1e9 * index * interval) for index in range(count)]
