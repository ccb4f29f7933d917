"""The planes of a FITS file, by astropy."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from blob_tracker.commands.sources.source import (
    frame_of, library, Source, SourceError, SourceFrame,
)
from blob_tracker.types import BAYER
import numpy as np
from numpy.typing import NDArray

SUFFIXES = ('.fit', '.fits', '.fts')
PACKED = ('.gz', '.fz')


def is_fits(path: Path) -> bool:
    """Tell whether a file has the name of a FITS, compressed or not."""
    name = path.name.lower()
    return name.endswith((*SUFFIXES, *(suffix + end for suffix in SUFFIXES for end in PACKED)))


def open_fits(path: Path) -> Source:
    """
    Open a file of one plane, of a cube of them, or of several pictures: each plane is a frame.

    Rows are taken as they are stored, the first one at the top, but those that ROWORDER says are
    BOTTOM-UP. A lone plane has the stamp of DATE-OBS, and half of EXPTIME later.

    Raises
    ------
    SourceError
        It cannot be read, or holds no pictures.

    """
    fits = library('astropy.io.fits', 'FITS files')
    try:
        file = fits.open(path, memmap=False)
        pictures = [
            (unit.header, unit.shape) for unit in file if unit.is_image and len(unit.shape) >= 2
        ]
    except (OSError, ValueError, TypeError):
        raise SourceError(f'{path} is not a FITS file that astropy can read') from None
    if not pictures:
        raise SourceError(f'{path} holds no picture')
    for header, shape in pictures:
        if len(shape) > 3:
            raise SourceError(
                f'{path} has {len(shape)} axes; frames one after the other have three at most'
            )
        if header.get('BAYERPAT') and _bottom_up(header):
            raise SourceError(
                f'{path} has colour filters and ROWORDER BOTTOM-UP, of which programs make '
                'different things; save it TOP-DOWN'
            )
    count = sum(shape[0] if len(shape) == 3 else 1 for _, shape in pictures)
    dated = all(len(shape) == 2 and _middle_ns(header) is not None for header, shape in pictures)
    return Source(_frames(path, file), count, 'DATE-OBS of the FITS header' if dated else '')


def _frames(path: Path, file: Any) -> Iterator[SourceFrame]:
    with file:
        number = 0
        for unit in file:
            if not unit.is_image or len(unit.shape) < 2:
                continue
            lone = len(unit.shape) == 2
            layout = str(unit.header.get('BAYERPAT', '')).strip().lower()
            pixels = np.asarray(unit.data)
            for plane in pixels[np.newaxis] if lone else pixels:
                number += 1
                yield frame_of(
                    _top_down(plane, unit.header), f'{path.name} plane {number}',
                    _middle_ns(unit.header) if lone else None, layout if layout in BAYER else '',
                )


def _bottom_up(header: Any) -> bool:
    return str(header.get('ROWORDER', '')).strip().upper() == 'BOTTOM-UP'


def _top_down(plane: NDArray[Any], header: Any) -> NDArray[Any]:
    return plane[::-1] if _bottom_up(header) else plane


def _middle_ns(header: Any) -> int | None:
    """Return the middle of the exposure, ns since 1970; None if the header does not tell."""
    try:
        # datetime64 takes any number of digits, and no name of a zone; FITS has UTC.
        begin = np.datetime64(str(header['DATE-OBS']).strip().rstrip('Z'), 'ns')
        exposure = float(header.get('EXPTIME', header.get('EXPOSURE', 0.0)))
    except (KeyError, ValueError):
        return None
    return int(begin.astype(np.int64)) + round(0.5e9 * exposure)
