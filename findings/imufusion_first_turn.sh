#!/usr/bin/env bash
# imufusion does not count a turn in its first three seconds.
#
# Expected: without a magnetometer the heading starts at zero and is what the gyroscope has summed
# up since.
# Happens: for the first three seconds, while the gain for the accelerometer is ramped down, each
# update sets the heading back to zero.
# Matters: a pan that starts moving at once has an offset for the rest of the run, as large as it
# had turned by then; a bench test that waits first shows nothing. Call skip_startup, or keep still
# until get_flags().startup is false.
#
# imufusion 1.3.3, heading after a turn of 30 degrees in one second (degrees):
#   from 1 s: 0.0, with skip_startup 30.0
#   from 2.5 s: 15.3, with skip_startup 30.0
#   from 4 s: 30.0, with skip_startup 30.0
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 imufusion==1.3.3
"$folder/venv/bin/python" -I - <<'END'
import imufusion
import numpy as np

PERIOD = 0.01  # s
UP = np.array([0.0, 0.0, 1.0])  # g


def heading(start: float, skip: bool) -> float:
    """Return the heading 10 s after the start of a filter that is turned for a second."""
    filter_ = imufusion.Ahrs()
    filter_.set_sample_period(PERIOD)
    if skip:
        filter_.skip_startup()
    for step in range(1000):
        rate = 30.0 if start <= step * PERIOD < start + 1 else 0.0  # degrees/s
        filter_.update_no_magnetometer(rate * UP, UP)
    return float(imufusion.quaternion_to_euler(filter_.get_quaternion())[2])


found = []
for start in (1.0, 2.5, 4.0):
    found.append((heading(start, False), heading(start, True)))
    print('from {:g} s: {:.1f}, with skip_startup {:.1f}'.format(start, *found[-1]))

if not np.allclose(found, [[0, 30], [15.3, 30], [30, 30]], atol=0.5):
    raise SystemExit('imufusion counts turns from the start by now.')
END
