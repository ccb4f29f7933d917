#!/usr/bin/env bash
# Pillow makes a 16-bit picture an 8-bit one by clipping it at 255.
#
# Expected: convert('L') scales, so that white stays white: of 16 bits the upper eight are kept.
# Happens: the values are taken as they are, and those beyond 255 become 255. convert('RGB') does so
# too.
# Matters: a frame of 12 bits is white wherever there is light: spots are larger, have flat tops and
# no other centroid to speak of. A dark one passes for right, and is, up to 255 DN.
#
# Pillow 13.0.0, a PNG with 100, 1000, 4095, 65535 DN:
#   L: 100 255 255 255
#   RGB: 100 255 255 255
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 pillow==13.0.0
"$folder/venv/bin/python" -I - <<'END'
from io import BytesIO

import numpy as np
from PIL import Image

PIXELS = np.array([[100, 1000, 4095, 65535]], np.uint16)  # DN

file = BytesIO()
Image.fromarray(PIXELS).save(file, 'png')
as_described = np.array_equal(np.asarray(Image.open(file)), PIXELS)
for mode in ('L', 'RGB'):
    found = np.asarray(Image.open(file).convert(mode)).reshape(4, -1)[:, 0].tolist()
    print(f'{mode}:', *found)
    as_described &= found == [100, 255, 255, 255]

if not as_described:
    raise SystemExit('Pillow no longer clips 16 bits at 255.')
END
