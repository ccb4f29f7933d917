#!/usr/bin/env bash
# A flash in the second field of a frame is lost by yadif and kept by bwdif.
#
# Expected: a filter that makes whole pictures of interlaced ones keeps what both fields have seen,
# at half the lines; yadif and bwdif differ in quality.
# Happens: yadif by default returns one picture a frame, at the time of the first field, whose
# other lines it draws from their neighbours. bwdif returns one a field: twice as many pictures.
# Matters: of a light that flashes for 20 ms half of the flashes are gone, and a blinking one that
# is in step with the camera is never there. Ask for mode=send_field.
#
# ffmpeg n9.0.2 of imageio-ffmpeg 0.8.1, 50 frames, 3 flashes in first fields and 3 in second ones:
#   yadif: 50 pictures, 3 with a flash
#   yadif=mode=send_field: 100 pictures, 6 with a flash
#   bwdif: 100 pictures, 6 with a flash
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

WIDTH, HEIGHT = 64, 48  # px
FIRST, SECOND = (5, 15, 25), (10, 20, 30)  # frames

film = np.full((50, HEIGHT, WIDTH), 30, np.uint8)
for frame in FIRST:
    film[frame, 20:26:2, 30:34] = 230
for frame in SECOND:
    film[frame, 21:27:2, 30:34] = 230

found = []
for name in ('yadif', 'yadif=mode=send_field', 'bwdif'):
    raw = ['-f', 'rawvideo', '-pix_fmt', 'gray']
    output = subprocess.run(
        [imageio_ffmpeg.get_ffmpeg_exe(), '-v', 'error', *raw,
         '-video_size', f'{WIDTH}x{HEIGHT}', '-i', '-', '-vf', f'setfield=tff,{name}',
         '-fps_mode', 'passthrough', *raw, '-'],
        input=film.tobytes(), capture_output=True, check=True).stdout
    pictures = np.frombuffer(output, np.uint8).reshape(-1, HEIGHT, WIDTH)
    found.append((len(pictures), int((pictures.max((1, 2)) > 130).sum())))
    print('{}: {} pictures, {} with a flash'.format(name, *found[-1]))

if found != [(50, 3), (100, 6), (100, 6)]:
    raise SystemExit('yadif no longer drops what the second field has seen.')
END
