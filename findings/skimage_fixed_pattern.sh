#!/usr/bin/env bash
# phase_cross_correlation of scikit-image sees no motion if the pixels differ by 0.1 % of the light.
#
# Expected: if a light moves by 3 px over a sensor whose pixels differ a little, its motion is
# found: it is a thousand times as bright.
# Happens: by default every spatial frequency counts the same, however little there is of it. A soft
# spot has few, the pattern of the pixels has all, and stays where it is: the shift is 0.0 px. With
# normalization=None it is 3 px.
# Matters: 0 is what a well-aimed tracker hopes to see. Simulations have no fixed pattern.
#
# scikit-image 0.25.2, shift in x, light of 1000 DN, sigma 2 px, fixed pattern of 0, 1 and 5 DN:
#   by default: 3.0, 0.0, 0.0 px
#   normalization=None: 3.0, 3.0, 3.0 px
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 scikit-image==0.25.2
"$folder/venv/bin/python" -I - <<'END'
import numpy as np
from skimage.registration import phase_cross_correlation

y, x = np.mgrid[:64, :64]
before, after = (
    1000.0 * np.exp(-((x - place) ** 2 + (y - 34.0) ** 2) / 8.0) for place in (30.0, 33.0)
)
pattern = np.random.default_rng(0).normal(0.0, 1.0, (64, 64))  # DN

as_described = True
for name, options, expected in (
        ('by default', {}, [3.0, 0.0, 0.0]),
        ('normalization=None', {'normalization': None}, [3.0, 3.0, 3.0])):
    shifts = []
    for strength in (0, 1, 5):
        fixed = strength * pattern
        shift, *_ = phase_cross_correlation(
            after + fixed, before + fixed, upsample_factor=10, **options)
        shifts.append(float(shift[1]))
    print(f'{name}:', ', '.join(f'{shift:.1f}' for shift in shifts), 'px')
    as_described &= bool(np.abs(np.subtract(shifts, expected)).max() < 0.05)

if not as_described:
    raise SystemExit('phase_cross_correlation no longer takes the fixed pattern for the picture.')
END
