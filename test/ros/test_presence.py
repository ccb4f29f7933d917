"""A process is in the graph while it loads, with a segment of the size that it needs."""

from __future__ import annotations

from pathlib import Path
import signal
import sys

from blob_tracker.resources import config_path
from blob_tracker.ros.diagnostics.shared_memory import VARIABLE
import pytest
from support.processes import Probe, probe, Process

LOADING = """
import signal, sys
from blob_tracker.ros import presence, process
signal.signal(signal.SIGUSR1, lambda *_: presence.leave())
# It is in the graph before it knows of its hidden node itself.
signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGUSR1])
assert process.begin(images=sys.argv[1] == 'images') == 0
signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGUSR1])
while True:
    signal.pause()
"""


def hidden(node: Probe) -> list[str]:
    """Return the names of the nodes that only hold a place."""
    return [name for name in node.get_node_names() if name.startswith('_loading_')]


def loading(kind: str, domain: int, profile: Path | str) -> Process:
    """Start a process that loads for ever."""
    command = [sys.executable, '-c', LOADING, kind]
    return Process(['env', f'{VARIABLE}={profile}', *command], domain)


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_and_its_participant(number: int, domain: int) -> None:
    """At once, without a trace: nothing of it stays in the graph until its lease ends."""
    with probe(domain) as node:
        with loading('images', domain, config_path('fastdds.xml')) as process:
            node.spin_until(lambda: hidden(node))
            assert process.end(number) == -number
        node.spin_until(lambda: not hidden(node))
    assert process.output == ''


def test_who_compiles_for_minutes_is_not_there(domain: int) -> None:
    """The hidden node is taken away while the process lives on."""
    with probe(domain) as node, loading('images', domain, '') as process:
        node.spin_until(lambda: hidden(node))
        process.send(signal.SIGUSR1)
        node.spin_until(lambda: not hidden(node))
        assert process.running


@pytest.mark.parametrize('kind, profile, mebibytes', [
    ('images', 'fastdds.xml', 32),
    ('results', 'fastdds.xml', 8),
    ('results', 'another', 16),
])
def test_a_segment_no_larger_than_what_is_published(
    kind: str, profile: str, mebibytes: int, domain: int, tmp_path: Path
) -> None:
    """Of results a smaller one; a profile of one's own is left as it is."""
    shipped = config_path('fastdds.xml')
    another = tmp_path / 'another'
    another.write_text(shipped.read_text().replace(str(32 << 20), str(16 << 20)))
    chosen = another if profile == 'another' else shipped
    with probe(domain) as node, loading(kind, domain, chosen) as process:
        node.spin_until(lambda: hidden(node))
        # Each segment is a mapping as large as it is, with descriptors of its buffers.
        lines = [line for line in process.libraries().splitlines() if '/dev/shm/fastrtps_' in line]
        sizes = [int(end, 16) - int(begin, 16) for line in lines
                 for begin, end in [line.split()[0].split('-')]]
    assert any(mebibytes << 20 <= size < (mebibytes + 2) << 20 for size in sizes)
