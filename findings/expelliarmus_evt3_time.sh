#!/usr/bin/env bash
# A recording of an event camera lasts twice as long as it did when expelliarmus reads it.
#
# Expected: stamps of EVT 3.0, the format of Prophesee's cameras, are 24 bits in two words, the
# upper 12 and the lower 12; a reader puts them together, and what a writer saves it can give to
# others.
# Happens: whenever the lower part starts again, the reader adds 4.096 ms of its own to the upper
# part, which the file has raised already. In the other direction its writer saves no upper part
# after the first, so that others find all events within 4 ms.
# Matters: its own files come back right while events are dense, so that a test there and back
# passes; with the file of a camera a light that flashes at 1 kHz does so at 500 Hz.
#
# expelliarmus 1.1.12 and evt3 0.4.1, 20 s with an event each millisecond, the last one at:
#   of the camera, read by evt3: 19.999 s
#   of the camera, read by expelliarmus: 39.996 s
#   written and read by expelliarmus: 19.999 s
#   written by expelliarmus, read by evt3: 0.004 s
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    numpy==2.2.6 expelliarmus==1.1.12 evt3==0.4.1
"$folder/venv/bin/python" -I - "$folder" <<'END'
import sys
from pathlib import Path

import evt3
from expelliarmus import Wizard
import numpy as np

COUNT, STEP = 20_000, 1000  # events, us
ROW, COLUMN = 20, 10
LIFTED = 1 << 11  # polarity
HEADER = b'% evt 3.0\n% format EVT3;height=720;width=1280\n% end\n'

folder = Path(sys.argv[1])
camera, own = folder / 'camera.raw', folder / 'own.raw'

words, upper = [], -1
for time in range(0, COUNT * STEP, STEP):
    while upper < time >> 12:
        upper += 1
        words.append(0x8000 | upper & 0xfff)
    words += [0x6000 | time & 0xfff, 0x0000 | ROW, 0x2000 | LIFTED | COLUMN]
camera.write_bytes(HEADER + np.array(words, '<u2').tobytes())

events = np.zeros(COUNT, [('t', '<i8'), ('x', '<i2'), ('y', '<i2'), ('p', 'u1')])
events['t'] = STEP * np.arange(COUNT)
events['x'], events['y'], events['p'] = COLUMN, ROW, 1
wizard = Wizard(encoding='evt3')
wizard.save(str(own), events)

found = []
for name, time in (
        ('of the camera, read by evt3', evt3.decode_file(str(camera)).timestamp[-1]),
        ('of the camera, read by expelliarmus', wizard.read(str(camera))['t'][-1]),
        ('written and read by expelliarmus', wizard.read(str(own))['t'][-1]),
        ('written by expelliarmus, read by evt3', evt3.decode_file(str(own)).timestamp.max())):
    found.append(1e-6 * int(time))
    print(f'{name}: {found[-1]:.3f} s')

if not (abs(found[0] - 19.999) < 1e-6 and abs(found[1] - 39.996) < 0.01
        and found[2] == found[0] and found[3] < 0.005):
    raise SystemExit('expelliarmus no longer reads twice the time and writes none.')
END
