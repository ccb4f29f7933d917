#!/usr/bin/env bash
# ffmpeg's fast_bilinear scaling shifts a picture by half a pixel, to the left and not up.
#
# Expected: a coarser interpolation, but of the same place: the centres of the old and the new
# picture stay together, as with bilinear.
# Happens: horizontally the first pixels are laid on one another instead, vertically the centres:
# the picture moves left by half a pixel of the larger of the two.
# Matters: the flag is a common recipe for small computers. Angles from such pictures are out by
# half a pixel in azimuth, and right in elevation.
#
# ffmpeg n9.0.2 of imageio-ffmpeg 0.8.1, error of the centroid of a light in x and y:
#   96 x 64 to 48 x 32, bilinear: +0.00, +0.01 px
#   96 x 64 to 48 x 32, fast_bilinear: -0.50, +0.01 px
#   96 x 64 to 192 x 128, bilinear: +0.00, +0.00 px
#   96 x 64 to 192 x 128, fast_bilinear: -0.50, +0.00 px
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 imageio-ffmpeg==0.8.1
"$folder/venv/bin/python" -I - <<'END'
import subprocess

import imageio_ffmpeg
import numpy as np

LIGHT = 48.3, 30.4  # px
y, x = np.mgrid[:64, :96]
PICTURE = 250 * np.exp(-((x - LIGHT[0]) ** 2 + (y - LIGHT[1]) ** 2) / 18)


def error(size: tuple[int, int], flags: str) -> np.ndarray:
    """Return how far the light is from where the scaled picture has it."""
    pixels = subprocess.run(
        [imageio_ffmpeg.get_ffmpeg_exe(), '-v', 'error',
         '-f', 'rawvideo', '-pix_fmt', 'gray', '-video_size', '96x64', '-i', '-',
         '-vf', f'scale={size[0]}:{size[1]}:flags={flags}',
         '-f', 'rawvideo', '-pix_fmt', 'gray', '-'],
        input=PICTURE.round().astype(np.uint8).tobytes(), capture_output=True, check=True).stdout
    picture = np.frombuffer(pixels, np.uint8).reshape(size[::-1]).astype(float)
    rows, columns = np.indices(picture.shape)
    centroid = np.array([(picture * columns).sum(), (picture * rows).sum()]) / picture.sum()
    off = centroid - ((np.array(LIGHT) + 0.5) * size[0] / 96 - 0.5)
    print(f'96 x 64 to {size[0]} x {size[1]}, {flags}: {off[0]:+.2f}, {off[1]:+.2f} px')
    return off


for size in ((48, 32), (192, 128)):
    if not (np.all(np.abs(error(size, 'bilinear')) < 0.05)
            and np.allclose(error(size, 'fast_bilinear'), [-0.5, 0], atol=0.05)):
        raise SystemExit('fast_bilinear no longer moves the picture by half a pixel.')
END
