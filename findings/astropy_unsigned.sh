#!/usr/bin/env bash
# astropy's CCDData subtracts a dark frame in uint16: a pixel below its dark becomes 65534.
#
# Expected: frames read from FITS with a unit are subtracted as astropy's quantities of the same
# pixels are, which become floats, and not as bare integers.
# Happens: CCDData keeps the camera's uint16, and so do subtract, and ccdproc's subtract_bias and
# subtract_dark: -2 wraps round.
# Matters: half of all pixels of an unlit background lie below their dark. Each becomes a
# saturated light.
#
# astropy 7.2.0, 10 and 20 adu less 12 and 5 adu:
#   CCDData: 65534 15
#   quantities: -2.0 15.0
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.3.5 astropy==7.2.0
cd "$folder"
"$folder/venv/bin/python" -I - <<'END'
from astropy.io import fits
from astropy.nddata import CCDData
import numpy as np

for name, values in (('light', [10, 20]), ('dark', [12, 5])):
    fits.writeto(f'{name}.fits', np.array([values], np.uint16))
light, dark = (CCDData.read(f'{name}.fits', unit='adu') for name in ('light', 'dark'))
subtracted = light.subtract(dark).data.ravel()
quantities = (light.data * light.unit - dark.data * dark.unit).value.ravel()
print('CCDData:', *subtracted)
print('quantities:', *quantities)
if subtracted.tolist() != [65534, 15] or quantities.tolist() != [-2, 15]:
    raise SystemExit('CCDData no longer subtracts in the unsigned integers of the camera.')
END
