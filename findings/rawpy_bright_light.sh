#!/usr/bin/env bash
# rawpy makes a whole frame brighter if a light in it is brighter than 75 % of white.
#
# Expected: a linear development (gamma 1, no_auto_bright, 16 bits) multiplies all raw frames of a
# camera by one number, 65535 over its white level.
# Happens: LibRaw takes the largest value of a frame for white if it is above 75 % of the white
# level of the camera (adjust_maximum_thr), and then stretches the frame to it.
# Matters: what stays as it is gets brighter by up to a third as a light nears saturation, and
# falls back as it saturates: a light that flashes makes all others flash. Pass
# adjust_maximum_thr=0.
#
# rawpy 0.28.0, a background of 1000 DN of 12 bits with a light of so many DN in it:
#   light of 2900: background 16003, with adjust_maximum_thr=0 16003
#   light of 3200: background 20479, with adjust_maximum_thr=0 16003
#   light of 3800: background 17246, with adjust_maximum_thr=0 16003
#   light of 4095: background 16003, with adjust_maximum_thr=0 16003
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 tifffile==2025.6.11 rawpy==0.28.0
"$folder/venv/bin/python" -I - "$folder/frame.dng" <<'END'
import sys

import numpy as np
import rawpy
import tifffile

BACKGROUND, WHITE = 1000, 4095  # DN
IDENTITY = (1, 1, 0, 1, 0, 1, 0, 1, 1, 1, 0, 1, 0, 1, 0, 1, 1, 1)  # of rationals
TAGS = (
    (33421, 'H', 2, (2, 2), True),  # CFARepeatPatternDim
    (33422, 'B', 4, bytes((0, 1, 1, 2)), True),  # CFAPattern: RGGB
    (50706, 'B', 4, bytes((1, 4, 0, 0)), True),  # DNGVersion
    (50708, 's', 0, 'Example', True),  # UniqueCameraModel
    (50714, 'H', 1, 0, True),  # BlackLevel
    (50717, 'H', 1, WHITE, True),  # WhiteLevel
    (50721, '2i', 9, IDENTITY, True),  # ColorMatrix1
    (50728, '2I', 3, (1, 1, 1, 1, 1, 1), True),  # AsShotNeutral
    (50778, 'H', 1, 21, True),  # CalibrationIlluminant1: D65
)


def background(light: int, **settings: float) -> int:
    """Return the background of a frame with a light after it was developed."""
    frame = np.full((200, 300), BACKGROUND, np.uint16)
    frame[100:110, 100:110] = light
    tifffile.imwrite(sys.argv[1], frame, photometric='CFA', extratags=TAGS, metadata=None)
    with rawpy.imread(sys.argv[1]) as raw:
        developed = raw.postprocess(
            gamma=(1, 1), no_auto_bright=True, output_bps=16, use_camera_wb=True,
            output_color=rawpy.ColorSpace.raw, **settings)
    return int(developed[20, 20, 1])


found = []
for light in (2900, 3200, 3800, 4095):
    found.append((background(light), background(light, adjust_maximum_thr=0.0)))
    print('light of {}: background {}, with adjust_maximum_thr=0 {}'.format(light, *found[-1]))

if not np.allclose(found, [[16003, 16003], [20479, 16003], [17246, 16003], [16003, 16003]],
                   atol=10):
    raise SystemExit('A bright light no longer changes how a frame is developed.')
END
