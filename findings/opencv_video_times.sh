#!/usr/bin/env bash
# The times that OpenCV gives to the frames of a film are 0 at its end, or everywhere.
#
# Expected: CAP_PROP_POS_MSEC after read() is the time of the frame that was read, or -1 where the
# film has none; a film whose stamps begin at 5 s begins at 5000 ms.
# Happens: where the file has no time for a frame, it is 0. With B frames in AVI that is so for the
# last ones, in a raw stream as libcamera-vid writes it (.h264) for all; the rate is then 25 Hz,
# the number of frames negative. Times count from the first frame, while CAP_PROP_FRAME_COUNT
# also counts the frames that might have been before it.
# Matters: a light whose frequency is taken from these times has a last frame at the start; two
# films with stamps of one clock lose what joins them.
#
# OpenCV 4.14.0, 30 frames at 60 Hz: number, rate, time of the first and the last, ms
#   film.mp4: 30, 60, 0.0 to 483.3
#   film.avi: 30, 60, 33.3 to 0.0
#   film.h264: -192153584101141, 25, 0.0 to 0.0
#   later.mkv: 330, 60, 0.0 to 483.0
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 opencv-python-headless==4.14.0.94 imageio-ffmpeg==0.8.1
cd "$folder"
export OPENCV_LOG_LEVEL=OFF OPENCV_FFMPEG_LOGLEVEL=-8
"$folder/venv/bin/python" -I - <<'END'
import subprocess

import cv2
import imageio_ffmpeg

found = {}
for name, options in (('film.mp4', []), ('film.avi', []), ('film.h264', []),
                      ('later.mkv', ['-output_ts_offset', '5'])):
    subprocess.run(
        [imageio_ffmpeg.get_ffmpeg_exe(), '-v', 'error', '-f', 'lavfi',
         '-i', 'testsrc=size=64x64:rate=60:duration=0.5', '-c:v', 'libx264', '-bf', '3',
         *options, name], check=True)
    film = cv2.VideoCapture(name)
    times = []
    while film.read()[0]:
        times.append(film.get(cv2.CAP_PROP_POS_MSEC))
    count, rate = film.get(cv2.CAP_PROP_FRAME_COUNT), film.get(cv2.CAP_PROP_FPS)
    print(f'{name}: {count:.0f}, {rate:.0f}, {times[0]:.1f} to {times[-1]:.1f}')
    found[name] = len(times), max(count, -1), round(rate), round(times[0]), round(times[-1])

if found != {'film.mp4': (30, 30, 60, 0, 483), 'film.avi': (30, 30, 60, 33, 0),
             'film.h264': (30, -1, 25, 0, 0), 'later.mkv': (30, 330, 60, 0, 483)}:
    raise SystemExit('The times of these films are no longer as described.')
END
