#!/usr/bin/env bash
# blob_log of scikit-image does not find a light of 12 bits that it finds in 8 bits.
#
# Expected: the same picture as uint8, uint16 or float has the same blobs; more bits do no harm.
# Happens: integers are divided by the largest number of their type, whatever the camera can give;
# floats are not. The threshold, by default 0.2, is for what comes of it.
# Matters: a camera of 12 bits in uint16 is 16 times too dark and its lights are not found, with no
# word. As floats their noise is found.
#
# scikit-image 0.25.2, a light of 4000 DN of 4095 with a noise of 2 DN, blobs:
#   uint8, 16 DN made 1: 1
#   uint16: 0
#   float64: 129
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 scikit-image==0.25.2
"$folder/venv/bin/python" -I - <<'END'
import numpy as np
from skimage.feature import blob_log

y, x = np.mgrid[:64, :64]
light = 4000.0 * np.exp(-((x - 30.0) ** 2 + (y - 34.0) ** 2) / 8.0)
frame = np.maximum(light + np.random.default_rng(0).normal(10.0, 2.0, light.shape), 0.0)
frames = {
    'uint8, 16 DN made 1': (frame / 16).astype(np.uint8),
    'uint16': frame.astype(np.uint16),
    'float64': frame,
}
found = []
for name, pixels in frames.items():
    found.append(len(blob_log(pixels)))
    print(f'{name}: {found[-1]}')
if not (found[:2] == [1, 0] and found[2] > 10):
    raise SystemExit('blob_log no longer divides 12 bits by 65535.')
END
