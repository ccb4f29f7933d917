#!/usr/bin/env bash
# scipy.ndimage.gaussian_filter makes a frame of whole numbers darker by 1 DN.
#
# Expected: a smoothed frame has the mean of the frame, whatever the type of its pixels.
# Happens: the result has the type of the frame, the filter goes over rows and columns one after the
# other, and each time the fraction is cut off: half a DN, twice. gaussian_laplace and sobel, which
# have negative values, give 65535 and the like for them.
# Matters: what is subtracted as background is too dark everywhere, by more than the noise that is
# left after smoothing. As floats, or with output=float, nothing is lost.
#
# SciPy 1.17.1, 100 DN with Poisson noise: what gaussian_filter adds to the mean, and the values of
# gaussian_laplace
#   uint16: -1.00 DN, 0 to 65535
#   uint16 with output=float: -0.00 DN, -6 to 6
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 scipy==1.17.1
"$folder/venv/bin/python" -I - <<'END'
import numpy as np
from scipy.ndimage import gaussian_filter, gaussian_laplace

frame = np.random.default_rng(0).poisson(100, (400, 400)).astype(np.uint16)
as_described = True
for name, options, expected, extreme in (
        ('uint16', {}, -1.0, 65535), ('uint16 with output=float', {'output': float}, 0.0, 6)):
    change = gaussian_filter(frame, 1.5, **options).mean() - frame.mean()
    edges = gaussian_laplace(frame, 1.5, **options)
    print(f'{name}: {change:+.2f} DN, {edges.min():.0f} to {edges.max():.0f}')
    as_described &= bool(abs(change - expected) < 0.05 and abs(edges.max() - extreme) < 2)

if not as_described:
    raise SystemExit('gaussian_filter no longer makes a frame of whole numbers darker.')
END
