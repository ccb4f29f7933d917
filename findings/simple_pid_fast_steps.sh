#!/usr/bin/env bash
# simple-pid answers with its first output for ever if it is called with dt=0.005.
#
# Expected: pid(position, dt=0.005) is a step of 5 ms; sample_time, 10 ms unless it is given, paces
# a loop that runs by the clock.
# Happens: sample_time holds for a dt that is given as well: a shorter step returns the last
# output, and its time is not added to the next one, so that no step is ever long enough.
# Matters: a pan that is simulated or replayed at 100 Hz is controlled, at 200 Hz it is not: its
# speed stays what it was at the first step. Pass sample_time=None.
#
# simple-pid 2.0.1, gain 1, outputs for errors of 0, 1, 2, 3 and 4:
#   dt=0.01: 0 1 2 3 4
#   dt=0.005: 0 0 0 0 0
#   dt=0.005, sample_time=None: 0 1 2 3 4
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    simple-pid==2.0.1
"$folder/venv/bin/python" -I - <<'END'
from simple_pid import PID


def outputs(dt: float, **settings: float | None) -> list[float]:
    """Return what a controller answers to an error that grows by 1 a step."""
    pid = PID(1.0, 0.0, 0.0, setpoint=0, **settings)
    return [pid(-error, dt=dt) for error in range(5)]


found = []
for name, dt, settings in (('dt=0.01', 0.01, {}),
                           ('dt=0.005', 0.005, {}),
                           ('dt=0.005, sample_time=None', 0.005, {'sample_time': None})):
    found.append(outputs(dt, **settings))
    print(name + ':', *(f'{output:.0f}' for output in found[-1]))

if found != [[0, 1, 2, 3, 4], [0] * 5, [0, 1, 2, 3, 4]]:
    raise SystemExit('simple-pid takes steps shorter than sample_time by now.')
END
