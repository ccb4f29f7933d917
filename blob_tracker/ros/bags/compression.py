"""What bags are compressed with: lz4 and zstd, as far as it is there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
import struct

from backports import zstd  # comes with rosbags, as lz4 does
from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]

BLOCK_BYTES = 1 << 20
ZSTD_MAGIC = b'\x28\xb5\x2f\xfd'
# What a damaged stream, or the head of a chunk before it, raises; KeyError: by an unknown method.
DECOMPRESSION_FAULTS: tuple[type[Exception], ...] = (
    zstd.ZstdError, RuntimeError, EOFError, KeyError, struct.error)
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
    decompressor, begun = zstd.ZstdDecompressor(), False
    with source.open('rb') as compressed, target.open('wb') as file:
        while block := compressed.read(BLOCK_BYTES):
            while block:
                begun = True
                try:
                    file.write(decompressor.decompress(block))
                except zstd.ZstdError:
                    return 'its compressed stream is damaged'
                block = b''
                if decompressor.eof:  # another stream may follow
                    block = decompressor.unused_data
                    decompressor, begun = zstd.ZstdDecompressor(), False
    return 'its compressed stream ends in the middle' if begun else ''
