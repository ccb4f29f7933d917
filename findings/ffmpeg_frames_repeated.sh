#!/usr/bin/env bash
# ffmpeg makes 12 pictures of a film of 6 frames: those that the camera lost are there again.
#
# Expected: `ffmpeg -i film.mkv %03d.png` writes each frame once, and so does a pipe of raw video.
# Happens: neither has time stamps, and ffmpeg keeps a constant rate for such outputs: a gap in the
# stamps is filled with the frames on either side of it. `-fps_mode passthrough` writes what is
# there. read_frames of imageio-ffmpeg reads by such a pipe.
# Matters: a count of frames says that none was lost, an error that is measured on them stands still
# at the gaps, and numbers of pictures are not those of frames.
#
# ffmpeg n9.0.2 of imageio-ffmpeg 0.8.1, frames 0 to 11 at 30 Hz without 3 to 8:
#   pictures: 0 1 2 2 2 2 2 2 9 9 10 11
#   pictures with -fps_mode passthrough: 0 1 2 9 10 11
#   read_frames: 0 1 2 2 2 2 2 2 9 9 10 11
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 imageio-ffmpeg==0.8.1 opencv-python-headless==4.14.0.94
cd "$folder"
"$folder/venv/bin/python" -I - <<'END'
import subprocess
from pathlib import Path

import cv2
import imageio_ffmpeg
import numpy as np

FFMPEG = [imageio_ffmpeg.get_ffmpeg_exe(), '-v', 'error', '-y']
EACH = ['-fps_mode', 'passthrough']
KEPT = [0, 1, 2, 9, 10, 11]
FILLED = [0, 1, 2, 2, 2, 2, 2, 2, 9, 9, 10, 11]

frames = b''.join(np.full((16, 16), 20 * number, np.uint8).tobytes() for number in range(12))
subprocess.run(
    [*FFMPEG, '-f', 'rawvideo', '-pix_fmt', 'gray', '-video_size', '16x16', '-framerate', '30',
     '-i', '-', '-vf', 'select=not(between(n\\,3\\,8))', *EACH, '-c:v', 'ffv1', 'film.mkv'],
    input=frames, check=True)

as_described = True
for name, options, expected in (('pictures', [], FILLED),
                                ('pictures with -fps_mode passthrough', EACH, KEPT)):
    folder = Path(name)
    folder.mkdir()
    subprocess.run([*FFMPEG, '-i', 'film.mkv', *options, str(folder / '%03d.png')], check=True)
    found = [int(cv2.imread(str(file), cv2.IMREAD_UNCHANGED)[0, 0]) // 20
             for file in sorted(folder.iterdir())]
    print(f'{name}:', *found)
    as_described &= found == expected

reader = imageio_ffmpeg.read_frames('film.mkv', pix_fmt='gray', bits_per_pixel=8)
next(reader)  # what is known of the film
read = [frame[0] // 20 for frame in reader]
print('read_frames:', *read)
if not (as_described and read == FILLED):
    raise SystemExit('ffmpeg no longer repeats frames where some were lost.')
END
