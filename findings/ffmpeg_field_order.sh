#!/usr/bin/env bash
# Most lossless codecs of ffmpeg lose which field of an interlaced picture came first.
#
# Expected: a film of a PAL camera, marked bottom field first (setfield=bff) and stored without
# loss, comes back with its mark, so that a deinterlacer plays its fields in their order.
# Happens: FFV1 does keep it. Frames of FFVHuff, Ut Video, HuffYUV and MJPEG come back as
# progressive, even from Matroska, whose header says what they are; bwdif then takes the top field
# for the first, and deint=interlaced would not touch them at all.
# Matters: the light goes two fields forth and one back, at twice the rate of the frames.
#
# ffmpeg n9.0.2 of imageio-ffmpeg 0.8.1, steps of a light that moves by 4 px a field:
#   ffv1 in mkv: 4 4 4 4 4 4
#   ffvhuff in mkv: -4 12 -4 12 -4 12
#   utvideo in avi: -4 12 -4 12 -4 12
#   mjpeg in mkv: -4 12 -4 12 -4 12
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 imageio-ffmpeg==0.8.1
cd "$folder"
"$folder/venv/bin/python" -I - <<'END'
import subprocess

import imageio_ffmpeg
import numpy as np

FFMPEG = imageio_ffmpeg.get_ffmpeg_exe()
STEP = 4  # px a field
FRAMES = 8
RAW = '-f', 'rawvideo', '-pix_fmt', 'gray'
y, x = np.mgrid[:64, :128]


def light(field: int) -> np.ndarray:
    """Return what the camera sees in the time of a field."""
    return 200 * np.exp(-((x - 20 - STEP * field) ** 2 + (y - 31.5) ** 2) / 50)


frames = np.array([light(2 * n) for n in range(FRAMES)])
frames[:, ::2] = [light(2 * n + 1)[::2] for n in range(FRAMES)]  # the upper field is the later one

FORWARD, ASTRAY = [STEP] * 6, [-STEP, 3 * STEP] * 3
as_described = True
for codec, kind, expected in (('ffv1', 'mkv', FORWARD), ('ffvhuff', 'mkv', ASTRAY),
                              ('utvideo', 'avi', ASTRAY), ('mjpeg', 'mkv', ASTRAY)):
    subprocess.run(
        [FFMPEG, '-v', 'error', '-y', *RAW, '-video_size', '128x64', '-i', '-',
         '-vf', 'setfield=bff', '-c:v', codec, '-q:v', '2', f'fields.{kind}'],
        input=frames.round().astype(np.uint8).tobytes(), check=True)
    pixels = subprocess.run(
        [FFMPEG, '-v', 'error', '-i', f'fields.{kind}', '-vf', 'bwdif', *RAW, '-'],
        capture_output=True, check=True).stdout
    fields = np.frombuffer(pixels, np.uint8).reshape(-1, 64, 128).astype(float)
    rows = fields.sum(1) * (fields.sum(1) > 100)  # without the noise of JPEG
    steps = np.diff((rows * np.arange(128)).sum(1) / rows.sum(1))[4:10]
    print(f'{codec} in {kind}:', *(f'{step:.0f}' for step in steps))
    as_described &= len(fields) == 2 * FRAMES and np.allclose(steps, expected, atol=1.5)

if not as_described:
    raise SystemExit('The codecs no longer keep or lose the order of the fields as described.')
END
