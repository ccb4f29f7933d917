#!/usr/bin/env bash
# Every second line of a picture has another sky in astropy than those lines had before.
#
# Expected: the WCS of frame[::2, ::2] gives pixel (10, 10) the direction that pixel (20, 20) has
# in the frame: it is that pixel.
# Happens: a step in a slice counts as binning: the new pixel is taken for the mean of 2 x 2 old
# ones, whose centre lies half an old pixel further.
# Matters: the fields of an interlaced camera, or the lines of one that skips, are taken this
# way. All bearings are off by half a pixel, those of the other field by the same.
#
# astropy 7.2.0, pixel (10, 10) of the slice, in pixels of the frame:
#   frame[::2, ::2]: 20.5, 20.5 instead of 20, 20
#   frame[1::2, ::2]: 20.5, 21.5 instead of 20, 21
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.3.5 astropy==7.2.0
"$folder/venv/bin/python" -I - <<'END'
from astropy.nddata import CCDData
from astropy.wcs import WCS
import numpy as np

sky = WCS(naxis=2)
sky.wcs.crpix = [1.0, 1.0]  # of FITS: the first pixel, at 0, 0
sky.wcs.ctype = ['XLIN', 'YLIN']
frame = CCDData(np.zeros((100, 100)), unit='adu', wcs=sky)

found = []
for name, part, true in (('frame[::2, ::2]', frame[::2, ::2], (20, 20)),
                         ('frame[1::2, ::2]', frame[1::2, ::2], (20, 21))):
    x, y = part.wcs.wcs_pix2world([[10, 10]], 0)[0]
    print(f'{name}: {x}, {y} instead of {true[0]}, {true[1]}')
    found.append((x - true[0], y - true[1]))
if not np.allclose(found, 0.5):
    raise SystemExit('A slice with a step no longer moves the WCS by half a pixel.')
END
