#!/usr/bin/env bash
# A spot of one pixel has a contourArea of 0, a disc of 10 px is 9.3 px across for fitEllipse.
#
# Expected: the area of a contour is that of the pixels within, and an ellipse that is fitted to it
# has their size, but for the pixels being square.
# Happens: a contour goes through the middles of the outermost pixels. Half a pixel is missing all
# around: n x n pixels have (n - 1)^2.
# Matters: a limit of 1 px for the area throws bright small lights away, and a distance by the size
# of a light is 8 % too large for 10 px.
#
# OpenCV 4.14.0, pixels, contourArea, diameter by the pixels and by fitEllipse:
#   1 px across: 1, 0.0
#   3 px across: 9, 4.0
#   disc of 10 px: 80, 66.0, 10.1, 9.3
#   disc of 20 px: 317, 288.5, 20.1, 19.2
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 opencv-python-headless==4.14.0.94
"$folder/venv/bin/python" -I - <<'END'
import cv2
import numpy as np

y, x = np.mgrid[:64, :64]


def size(light: np.ndarray) -> tuple[int, float, np.ndarray]:
    """Return the number of pixels, and the area of the contour and the contour."""
    contours, _ = cv2.findContours(
        light.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    return int(light.sum()), cv2.contourArea(contours[0]), contours[0]


as_described = True
for across in (1, 3):
    pixels, area, _ = size((abs(x - 30) <= across // 2) & (abs(y - 31) <= across // 2))
    print(f'{across} px across: {pixels}, {area}')
    as_described &= (pixels, area) == (across ** 2, (across - 1) ** 2)
for across in (10, 20):
    pixels, area, contour = size((x - 30.3) ** 2 + (y - 31.6) ** 2 <= (across / 2) ** 2)
    diameter, fitted = 2 * np.sqrt(pixels / np.pi), np.mean(cv2.fitEllipse(contour)[1])
    print(f'disc of {across} px: {pixels}, {area}, {diameter:.1f}, {fitted:.1f}')
    as_described &= bool(area < 0.93 * pixels and 0.6 < diameter - fitted < 1.1)

if not as_described:
    raise SystemExit('Contours no longer go through the middles of the outermost pixels.')
END
