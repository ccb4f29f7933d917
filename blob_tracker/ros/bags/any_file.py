"""A file of a bag, of whatever storage, compressed or not."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

from blob_tracker.ros.bags import compression, mcap_file, ros1_file, sqlite3_file
from blob_tracker.ros.bags.topic import BagFile, RecordingError


def opened_file(path: Path, stack: ExitStack, flaws: list[str]) -> BagFile:
    """
    Open a file of a bag by what it begins with, for as long as the stack is.

    `flaws` takes what is wrong with it before it is read. Raises RecordingError where nothing of
    it can be read.
    """
    with path.open('rb') as content:
        start = content.read(16)
    if start.startswith(compression.ZSTD_MAGIC):
        folder = Path(stack.enter_context(TemporaryDirectory(prefix='bag_')))
        inner = folder / path.stem
        flaw = compression.decompress_file(path, inner)
        if flaw:
            flaws.append(f'{path.name}: {flaw}')
        try:
            return opened_file(inner, stack, flaws)
        except RecordingError as error:
            said = str(error).replace(str(inner), str(path))
            raise RecordingError(f'{said}: {flaw}' if flaw else said) from None
    file: BagFile
    if start.startswith(mcap_file.MAGIC):
        file = mcap_file.McapFile(path)
    elif start.startswith(sqlite3_file.MAGIC):
        file = sqlite3_file.Sqlite3File(path)
    elif start.startswith(ros1_file.MAGIC):
        file = ros1_file.Ros1File(path)
    else:
        what = 'is empty' if not start else 'is neither mcap nor sqlite3 nor a bag of ROS 1'
        raise RecordingError(f'{path} {what}')
    stack.callback(file.close)
    return file
