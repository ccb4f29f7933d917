"""The frames of a raw dump: one after the other as a camera's buffers hold them, nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from blob_tracker.capture.pixel_formats import PIXEL_FORMATS
from blob_tracker.capture.pixel_formats.sizes import picture_bytes
from blob_tracker.commands.sources.source import Source, SourceError, SourceFrame
from blob_tracker.types import Frame


def open_raw(path: Path, pixel_format: str, size: tuple[int, int] | None, stride: int) -> Source:
    """
    Open a dump, as `v4l2-ctl --stream-to` writes it.

    Parameters
    ----------
    path : Path
        The file.
    pixel_format : str
        Of V4L2, see `PIXEL_FORMATS`.
    size : (int, int) or None
        Width and height, px.
    stride : int
        Distance of two lines, bytes; 0 where they touch.

    Raises
    ------
    SourceError
        There is no such format, or the file is no whole number of such pictures.

    """
    if size is None:
        raise SourceError(f'{path} does not say how large its pictures are: give --size 640x480')
    known = PIXEL_FORMATS.get(pixel_format)
    if known is None or known.compressed:
        raise SourceError(
            f'--pixel-format {pixel_format} is none of a raw dump; write one of '
            + ', '.join(name for name, each in PIXEL_FORMATS.items() if not each.compressed)
        )
    picture = picture_bytes(pixel_format, *size, stride)
    there = path.stat().st_size
    count, left = divmod(there, picture)
    if left or not count:
        raise SourceError(
            f'{path} has {there} bytes and a picture of {size[0]} x {size[1]} px in '
            f'{pixel_format} takes {picture}: that is not a whole number of them; give the right '
            '--size and --pixel-format, and --stride if the lines are padded'
        )
    return Source(_frames(path, pixel_format, size, stride, picture), count)


def _frames(
    path: Path, pixel_format: str, size: tuple[int, int], stride: int, picture: int
) -> Iterator[SourceFrame]:
    read_as = PIXEL_FORMATS[pixel_format]
    decoder, saturation = read_as.luma, read_as.saturation
    if read_as.colours is not None:
        decoder, saturation = read_as.colours, read_as.colour_saturation
    layout = read_as.layout if read_as.colours is not None else 'grey'
    number = 0
    with path.open('rb') as file:
        while data := file.read(picture):
            try:
                pixels = decoder(data, *size, stride)
            except ValueError as error:
                raise SourceError(f'{path}, picture {number + 1}: {error}') from None
            number += 1
            frame = Frame(pixels, 0, saturation, layout=layout)
            yield SourceFrame(f'picture {number}', frame, False)
