#!/usr/bin/env bash
# pyxdf closes the gap of frames that were lost: the stamps of a camera are made a straight line.
#
# Expected: load_xdf gives the stamps that were recorded, in the common clock, so that frames that
# were lost are a gap.
# Happens: the stamps of a stream with a nominal rate are replaced by a straight line fitted to
# them, unless its description says can_drop_samples (under synchronization). Only a gap longer
# than both a second and 500 samples, 17 s at 30 Hz, breaks the line; others are spread over it.
# Matters: a flash is up to half a gap early or late against other streams, and a count of lost
# frames finds none. Pass dejitter_timestamps=False for a camera.
#
# pyxdf 1.17.5, 20 s at 30 frames a second of which half a second was lost in the middle:
#   as it is: longest step 34.6 ms, stamps wrong by up to 252.6 ms
#   dejitter_timestamps=False: longest step 533.3 ms, stamps wrong by up to 0.0 ms
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 pyxdf==1.17.5
"$folder/venv/bin/python" -I - "$folder/camera.xdf" <<'END'
from pathlib import Path
import struct
import sys

import numpy as np
import pyxdf

RATE = 30  # frames/s
HEADER = (
    '<info><name>camera</name><type>Video</type><channel_count>1</channel_count>'
    f'<nominal_srate>{RATE}</nominal_srate><channel_format>double64</channel_format></info>')
STREAM = struct.pack('<I', 1)


def chunk(tag: int, content: bytes) -> bytes:
    """Return a chunk of an XDF file: its length, its tag and what is in it."""
    return struct.pack('<BIH', 4, len(content) + 2, tag) + content


frames = np.concatenate([np.arange(300), np.arange(315, 600)])
stamps = 1000 + frames / RATE
samples = b''.join(struct.pack('<Bdd', 8, *sample) for sample in zip(stamps, frames))
Path(sys.argv[1]).write_bytes(
    b'XDF:' + chunk(1, b'<info><version>1.0</version></info>')
    + chunk(2, STREAM + HEADER.encode())
    + chunk(3, STREAM + struct.pack('<BI', 4, len(frames)) + samples)
    + chunk(6, STREAM + f'<info><sample_count>{len(frames)}</sample_count></info>'.encode()))

found = []
for name, settings in (('as it is', {}),
                       ('dejitter_timestamps=False', {'dejitter_timestamps': False})):
    (stream,), _ = pyxdf.load_xdf(sys.argv[1], synchronize_clocks=False, **settings)
    read = stream['time_stamps']
    found.append((1e3 * np.diff(read).max(), 1e3 * np.abs(read - stamps).max()))
    print('{}: longest step {:.1f} ms, stamps wrong by up to {:.1f} ms'.format(name, *found[-1]))

if not np.allclose(found, [[34.6, 252.6], [533.3, 0.0]], atol=0.1):
    raise SystemExit('pyxdf keeps the gap of frames that were lost by now.')
END
