"""What bags are compressed with: lz4 and zstd, as far as it is there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
import shutil
import struct

from backports import zstd  # comes with rosbags, as lz4 does
from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]

ZSTD_MAGIC = b'\x28\xb5\x2f\xfd'
# What a damaged stream, or the head of a chunk before it, raises; KeyError: by an unknown method.
DECOMPRESSION_FAULTS: tuple[type[Exception], ...] = (
    zstd.ZstdError, RuntimeError, EOFError, KeyError, UnicodeDecodeError, struct.error)
_DECOMPRESSORS: dict[str, Callable[[bytes], bytes]] = {
    '': bytes,
    'lz4': lambda data: LZ4FrameDecompressor().decompress(data),
    'zstd': lambda data: zstd.ZstdDecompressor().decompress(data),
}


def decompressed(data: bytes, algorithm: str) -> bytes:
    """
    Return decompressed bytes; of a stream that was cut, those that are there.

    Raises
    ------
    One of `DECOMPRESSION_FAULTS`.

    """
    return _DECOMPRESSORS[algorithm](data)


def decompress_file(source: Path, target: Path) -> str:
    """Decompress a file of zstd as far as it goes; returns what is wrong with it, or ''."""
    with source.open('rb') as compressed, target.open('wb') as file:
        try:
            with zstd.open(compressed, 'rb') as stream:
                shutil.copyfileobj(stream, file)
        except (zstd.ZstdError, EOFError):
            return 'its compressed stream is cut or damaged'
    return ''
