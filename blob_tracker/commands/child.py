"""A node in a process of its own, which ends with the block that it is used in."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
import signal
import subprocess

# s that a node has to end by itself: a fifth of one on a quiet machine. One that is killed
# is still listed by others for the 20 s that Fast DDS waits for its next sign of life.
GRACE = 10.0


@contextmanager
def child(
    command: Sequence[str | Path],
    namespace: str,
    parameters: Mapping[str, str],
    log: Path,
    environment: Mapping[str, str] | None = None,
) -> Iterator[subprocess.Popen[bytes]]:
    """
    Run a node with its output in a log file, and end it with the block.

    Parameters
    ----------
    command : sequence of str or Path
        What starts it.
    namespace : str
        Of its topics.
    parameters : mapping
        Value by name.
    log : Path
        The file that its output goes to.
    environment : mapping, optional
        Environment variables; those of this process if left out.

    """
    words = [*map(str, command), '--ros-args', '-r', f'__ns:={namespace}']
    for name, value in parameters.items():
        words += ['-p', f'{name}:={value}']
    with open(log, 'wb') as file:
        # A session of its own: Ctrl-C reaches this process alone, which ends the nodes in order.
        process = subprocess.Popen(
            words,
            stdout=file,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            env=environment,
        )
        try:
            yield process
        finally:
            process.send_signal(signal.SIGINT)
            try:
                process.wait(GRACE)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
