"""The images of a folder, in the order of their names."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
import re

from blob_tracker.commands.sources.fits import is_fits, open_fits
from blob_tracker.commands.sources.source import frame_of, Source, SourceError, SourceFrame
from blob_tracker.commands.sources.tiff import open_tiff, SUFFIXES as TIFFS
import cv2
import numpy as np

SUFFIXES = ('.bmp', '.jpeg', '.jpg', '.pgm', '.png', *TIFFS)


def open_folder(folder: Path) -> Source:
    """
    Open a folder of images; each page of a TIFF, and each plane of a FITS, is one.

    Raises
    ------
    SourceError
        It is a file, holds no images, or both FITS and others.

    """
    files = _files(folder)
    fits = [file for file in files if is_fits(file)]
    if fits and len(fits) < len(files):
        raise SourceError(
            f'{folder} holds FITS files and other images; part them into two folders'
        )
    if fits:
        first = open_fits(fits[0])
        # Most such folders have a plane in each file, and nobody waits for all to be opened.
        return Source(_of_fits(fits), (first.count or 1) * len(files), first.stamps)
    return open_images(files)


def open_images(files: Sequence[Path]) -> Source:
    """
    Open images; each page of a TIFF is one.

    Raises
    ------
    SourceError
        On the way, of one that cannot be read.

    """
    pages = {file: cv2.imcount(str(file)) for file in files if file.suffix.lower() in TIFFS}
    return Source(_of_images(files, pages), sum(max(pages.get(file, 1), 1) for file in files))


def _files(folder: Path) -> list[Path]:
    """Return the image files of a folder, view2 before view10, and none that is hidden."""
    if not folder.is_dir():
        raise SourceError(f'{folder} is a file; give the folder that holds the images')
    files = [
        file for file in folder.iterdir()
        if not file.name.startswith('.') and (file.suffix.lower() in SUFFIXES or is_fits(file))
    ]
    if not files:
        raise SourceError(
            f'{folder} holds no images ({" ".join(SUFFIXES)} .fits) and is not a bag'
        )
    return sorted(
        files,
        key=lambda file: [
            (int(part), '') if part.isdigit() else (-1, part)
            for part in re.split(r'(\d+)', file.name)
        ],
    )


def _of_fits(files: Sequence[Path]) -> Iterator[SourceFrame]:
    for file in files:
        yield from open_fits(file).frames


def _of_images(files: Sequence[Path], pages: dict[Path, int]) -> Iterator[SourceFrame]:
    for file in files:
        if pages.get(file, 1) > 1:
            yield from open_tiff(file).frames
            continue
        pixels = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
        if pixels is None:
            raise SourceError(f'{file} is not an image that can be read; take it out')
        colours = {3: 'bgr', 4: 'bgra'}.get(pixels.shape[2], '') if pixels.ndim == 3 else ''
        yield frame_of(np.asarray(pixels), file.name, None, colours)
