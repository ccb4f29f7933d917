#!/usr/bin/env bash
# faery cannot read the times of a slow flash that it has saved as EVT 3.0 itself.
#
# Expected: events with stamps of 64 bits come back from a file .raw with the times they had, a
# minute or an hour later.
# Happens: stamps of the format are 24 bits, 16.8 s, and start again. A camera keeps counting aloud
# while nothing happens. faery writes the count with events alone, and where it starts again in a
# pause its reader loses the thread: from there on time stands still.
# Matters: a recording of a whole scene comes back right, since something happens all the time. One
# that was cut down to a single light before it was saved loses its times, without a word.
#
# faery 0.7.1, an event each 10 ms for a minute, the last one at:
#   dat: 59.990 s
#   raw: 16.777 s
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 faery==0.7.1
"$folder/venv/bin/python" -I - "$folder" <<'END'
import sys
from pathlib import Path

import faery
import numpy as np

COUNT, STEP = 6000, 10_000  # events, us

folder = Path(sys.argv[1])
events = np.zeros(COUNT, faery.EVENTS_DTYPE)
events['t'] = STEP * np.arange(COUNT)
events['x'], events['y'], events['on'] = 10, 20, True

found = []
for form in ('dat', 'raw'):
    path = folder / f'light.{form}'
    faery.events_stream_from_array(events, (1280, 720)).to_file(path)
    found.append(1e-6 * int(faery.events_stream_from_file(path).to_array()['t'][-1]))
    print(f'{form}: {found[-1]:.3f} s')

if not (abs(found[0] - 59.99) < 1e-6 and found[1] < 17):
    raise SystemExit('faery reads the times of its own EVT 3.0 by now.')
END
