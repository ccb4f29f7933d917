#!/usr/bin/env bash
# The robust noise of a frame is 0, 1.48 or 2.97 DN, and nothing between: mad_std of Astropy.
#
# Expected: mad_std is a standard deviation that outliers do not disturb; for a dark frame with a
# noise of 0.6 DN it is 0.6 DN, or 0.67 DN with what rounding to whole DN adds.
# Happens: the median of whole deviations is a whole number, which is multiplied by 1.4826. A noise
# below about 0.7 DN is 0, one of 0.8 to 2 DN is 1.48. More pixels do not help.
# Matters: a threshold of 5 times the noise is the background itself for a quiet camera, and every
# other pixel a light; for a louder one it is wrong by up to a half. sigma_clipped_stats has no such
# steps.
#
# Astropy 7.1.1, 160000 pixels of whole DN, noise: mad_std, and by sigma_clipped_stats
#   0.6: 0.00, 0.67
#   0.8: 1.48, 0.84
#   1.2: 1.48, 1.21
#   2.0: 1.48, 2.01
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 astropy==7.1.1
"$folder/venv/bin/python" -I - <<'END'
import numpy as np
from astropy.stats import mad_std, sigma_clipped_stats

as_described = True
for noise, expected in ((0.6, 0.0), (0.8, 1.4826), (1.2, 1.4826), (2.0, 1.4826)):
    frame = np.random.default_rng(0).normal(10.2, noise, (400, 400)).round().astype(np.uint16)
    found, clipped = mad_std(frame), sigma_clipped_stats(frame)[2]
    print(f'{noise}: {found:.2f}, {clipped:.2f}')
    as_described &= bool(abs(found - expected) < 0.001 and abs(clipped - noise) < 0.1)

if not as_described:
    raise SystemExit('mad_std of whole numbers no longer goes in steps of 1.48.')
END
