#!/usr/bin/env bash
# A pixel of an event camera that fires steadily is silenced for good by a refractory period.
#
# Expected: RefractoryPeriod(100) keeps an event and drops those of the same pixel for 100 us: of
# one event each 60 us every other one stays, at most one in 100 us.
# Happens: an event that is dropped starts the period anew. A pixel whose events are never further
# apart than the period has its first one, and then none until it pauses.
# Matters: meant to thin out bright lights, it removes the brightest ones whole and keeps the rest.
#
# tonic 1.7.0, 1000 events of one pixel, so many us apart, that are left:
#   120 us: 1000
#   101 us: 1000
#   100 us: 1
#   60 us: 1
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 scipy==1.15.3 tonic==1.7.0
"$folder/venv/bin/python" -I - <<'END'
import numpy as np
from tonic.transforms import RefractoryPeriod

EVENT = np.dtype([('x', np.int16), ('y', np.int16), ('t', np.int64), ('p', bool)])

found = []
for apart in (120, 101, 100, 60):
    events = np.zeros(1000, EVENT)
    events['t'] = 1000 + apart * np.arange(len(events))
    found.append(len(RefractoryPeriod(100)(events)))
    print(f'{apart} us: {found[-1]}')

if found != [1000, 1000, 1, 1]:
    raise SystemExit('A refractory period starts with events that are kept only by now.')
END
