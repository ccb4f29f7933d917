#!/usr/bin/env bash
# ccdproc scales a flat field by pixels of it that are masked.
#
# Expected: flat_correct divides by the flat over its mean, and masked pixels, as dark corners
# outside the image circle of a lens, do not count for the mean.
# Happens: the mean is that of the data, masked or not.
# Matters: all pixels that are not masked are too dark by the share of the mask, and fluxes of two
# cameras do not compare. Pass norm_value, the mean of what is not masked.
#
# ccdproc 2.5.1, frame of 100, flat of 1000 and, in its masked half, 1; the frame after it:
#   as it is: 50.3
#   norm_value: 100.0
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 scipy==1.15.3 astropy==7.1.0 ccdproc==2.5.1
"$folder/venv/bin/python" -I - <<'END'
from astropy.nddata import CCDData
from ccdproc import flat_correct
import numpy as np

y, x = np.mgrid[:100, :100] - 49.5
outside = np.hypot(x, y) > 40  # of the image circle
flat = CCDData(np.where(outside, 1.0, 1000.0), mask=outside, unit='adu')
frame = CCDData(np.full(flat.shape, 100.0), unit='adu')

found = []
for name, settings in (('as it is', {}),
                       ('norm_value', {'norm_value': flat.data[~outside].mean()})):
    found.append(float(flat_correct(frame, flat, **settings).data[~outside].mean()))
    print(f'{name}: {found[-1]:.1f}')

if not np.allclose(found, [50.3, 100.0], atol=0.1):
    raise SystemExit('Masked pixels of a flat do not count by now.')
END
