#!/usr/bin/env bash
# ffmpeg dithers when it makes 8 bits of a 12 or 16-bit picture: an even background gets a pattern.
#
# Expected: the grey level divided and rounded, the same for every pixel of the same value.
# Happens: pixels of one value become two neighbouring ones, in a pattern of 8 x 8 that is the same
# in each frame, without any option that asks for it. `-sws_dither none` turns it off.
# Matters: it is a fixed pattern of half a grey level that no sensor made. The variance over the
# pixels of such a film is that of the pattern, and a faint light sits on it.
#
# ffmpeg n9.0.2 of imageio-ffmpeg 0.8.1, 64 x 64 pixels of 1000 of 4095, which is 62.27 of 255:
#   62: 2816 pixels, 63: 1280 pixels; without dither 63: 4096 pixels
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

PICTURE = np.full((64, 64), 1000, '<u2')


def eight_bits(*options: str) -> dict[int, int]:
    """Return how many pixels have each value after the conversion."""
    found = subprocess.run(
        [imageio_ffmpeg.get_ffmpeg_exe(), '-v', 'error',
         '-f', 'rawvideo', '-pix_fmt', 'gray12le', '-video_size', '64x64', '-i', '-',
         *options, '-f', 'rawvideo', '-pix_fmt', 'gray', '-'],
        input=PICTURE.tobytes(), capture_output=True, check=True).stdout
    values, pixels = np.unique(np.frombuffer(found, np.uint8), return_counts=True)
    print(*options, ', '.join(f'{v}: {n} pixels' for v, n in zip(values, pixels)))
    return dict(zip(values.tolist(), pixels.tolist()))


plain, without = eight_bits(), eight_bits('-sws_dither', 'none')
if not (set(plain) == {62, 63} and min(plain.values()) > 500 and len(without) == 1):
    raise SystemExit('ffmpeg no longer dithers 12 bits to 8 unless it is told not to.')
END
