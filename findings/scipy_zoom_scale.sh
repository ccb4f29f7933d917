#!/usr/bin/env bash
# scipy.ndimage.zoom by 2 enlarges by a little more than 2 and moves all but the middle.
#
# Expected: zoom(frame, 2) makes two pixels of each one: what was at x is at 2 x + 0.5.
# Happens: the middles of the outermost pixels become those of the outermost pixels of the larger
# picture. The scale is (2 n - 1) / (n - 1), for 101 pixels 2.01, and x is at 2.01 x. With
# grid_mode=True it is as expected.
# Matters: the error is 0 in the middle, where one looks, and half a pixel at the edges; for a frame
# made smaller likewise. It passes for a wrong focal length.
#
# SciPy 1.17.1, a light at 20, 50 and 80 px of 101, less 2 x + 0.5:
#   as it is: -0.30 +0.00 +0.30 px
#   grid_mode=True: +0.00 +0.00 +0.00 px
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 scipy==1.17.1
"$folder/venv/bin/python" -I - <<'END'
import numpy as np
from scipy.ndimage import center_of_mass, zoom

PLACES = np.array([20.0, 50.0, 80.0])  # px

y, x = np.mgrid[:101, :101]
lights = [np.exp(-((x - place) ** 2 + (y - 50.0) ** 2) / 8.0) for place in PLACES]
as_described = True
for name, options, expected in (
        ('as it is', {}, [-0.3, 0.0, 0.3]),
        ('grid_mode=True', {'grid_mode': True, 'mode': 'grid-constant'}, [0.0, 0.0, 0.0])):
    found = [center_of_mass(zoom(light, 2, **options))[1] for light in lights]
    errors = np.array(found) - (2.0 * PLACES + 0.5)
    print(f'{name}:', *(f'{error:+.2f}' for error in errors.round(2) + 0.0), 'px')
    as_described &= bool(np.abs(errors - expected).max() < 0.01)

if not as_described:
    raise SystemExit('zoom(frame, 2) no longer enlarges by (2 n - 1) / (n - 1).')
END
