#!/usr/bin/env bash
# Pint lets a radiant intensity pass for a power, and 1 Hz for 9.5 turns a minute.
#
# Expected: units are there so that W/sr plus W fails, lumen in candela as well; and 1 Hz of a
# rotating light is 60 rpm.
# Happens: radian and steradian are the plain number 1, as in the SI: intensity and flux are of one
# dimension and convert by a factor of 1. A turn is 2 pi, so that Hz, which is 1/s, is taken for
# radians a second.
# Matters: the solid angle of a beam can be left out of a link budget unnoticed, which is what
# units were to prevent; a rate of flashes that came as rpm is wrong by 6.28.
#
# Pint 0.25.3:
#   100 lm is 100 cd
#   0.2 W/sr + 0.2 W is 0.4 W/sr
#   1 Hz is 9.549 rpm
#   60 rpm is 6.283 Hz
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    pint==0.25.3
"$folder/venv/bin/python" -I - <<'END'
import pint

units = pint.UnitRegistry()
flux = (100 * units.lumen).to('candela')
power = 0.2 * units('W/sr') + 0.2 * units('W')
fast = (1 * units.hertz).to('rpm')
slow = (60 * units.rpm).to('hertz')
print(f'100 lm is {flux:.0f~P}')
print(f'0.2 W/sr + 0.2 W is {power:.1f~P}')
print(f'1 Hz is {fast:.3f~P}')
print(f'60 rpm is {slow:.3f~P}')

if not (flux.magnitude == 100 and abs(power.magnitude - 0.4) < 1e-9
        and abs(fast.magnitude - 9.549) < 1e-3 and abs(slow.magnitude - 6.283) < 1e-3):
    raise SystemExit('Pint tells angles from numbers by now.')
END
