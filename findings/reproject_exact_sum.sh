#!/usr/bin/env bash
# A star has four times its counts after reproject_exact, which conserves flux.
#
# Expected: a reprojection that conserves flux keeps the sum of a star in counts, whatever the size
# of the new pixels.
# Happens: pixels are taken for a surface brightness, that is, for counts by solid angle: each new
# one is a weighted mean. Twice as many pixels a side give four times the sum.
# Matters: frames of two cameras laid on one grid differ by the ratio of their pixels' areas; with
# the same scale they agree, which is how it is mostly tried first. Multiply by that ratio.
#
# reproject 0.21.0, sum of a star on the new grid, of 1000 before:
#   the same pixels: 1000
#   half as wide: 4000
#   twice as wide: 250
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 astropy==7.1.0 reproject==0.21.0
"$folder/venv/bin/python" -I - <<'END'
from astropy.wcs import WCS
import numpy as np
from reproject import reproject_exact

WIDTH, SCALE = 32, 0.01  # px, degrees


def grid(ratio: float) -> tuple[WCS, tuple[int, int]]:
    """Return a grid about the same place whose pixels are wider by a ratio."""
    width = round(WIDTH / ratio)
    sky = WCS(naxis=2)
    sky.wcs.ctype = 'RA---TAN', 'DEC--TAN'
    sky.wcs.crval = 10.0, 0.0
    sky.wcs.crpix = 2 * [(width + 1) / 2]
    sky.wcs.cdelt = -SCALE * ratio, SCALE * ratio
    return sky, (width, width)


y, x = np.mgrid[:WIDTH, :WIDTH] - (WIDTH - 1) / 2
star = np.exp(-(x ** 2 + y ** 2) / (2 * 1.5 ** 2))
star *= 1000 / star.sum()
found = []
for name, ratio in (('the same pixels', 1.0), ('half as wide', 0.5), ('twice as wide', 2.0)):
    new, shape = grid(ratio)
    found.append(np.nansum(reproject_exact((star, grid(1.0)[0]), new, shape_out=shape)[0]))
    print(f'{name}: {found[-1]:.0f}')

if not np.allclose(found, [1000, 4000, 250], rtol=0.01):
    raise SystemExit('reproject_exact keeps the sum by now.')
END
