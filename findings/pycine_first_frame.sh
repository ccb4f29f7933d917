#!/usr/bin/env bash
# pycine, asked for the first frame of a Phantom film by its number, gives the last one.
#
# Expected: read_frames(start_frame_cine=n) starts with the frame that Phantom's own software calls
# n, as its documentation says; FirstImageNo is the first of the file.
# Happens: the number is counted from 0 and taken as counted from 1. Films start a frame too early,
# and in front of the first lies, as in any list of Python, the last. 0 is taken for "not given".
# Matters: the trigger is at frame 0: the flash that was filmed seems to come a frame late.
#
# pycine 0.3.2, frames -2, -1, 0 and 1, whose pixels have the frame's number + 100:
#   from -2: 101 98
#   from 0: 98 99
#   from 1: 100 101
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: numpy==2.2.6
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --no-deps pycine==0.3.2
cd "$folder"
"$folder/venv/bin/python" -I - <<'END'
from ctypes import sizeof

import numpy as np
from pycine.cine import BITMAPINFOHEADER, CINEFILEHEADER, SETUP
from pycine.raw import read_frames

FIRST, FRAMES = -2, 4
SIDE = 4  # px
IMAGE = 8 + 2 * SIDE * SIDE  # bytes: two lengths and the pixels

setup_at = sizeof(CINEFILEHEADER) + sizeof(BITMAPINFOHEADER)
table_at = setup_at + sizeof(SETUP)
images_at = table_at + 8 * FRAMES
head = CINEFILEHEADER(
    Type=int.from_bytes(b'CI', 'little'), Headersize=sizeof(CINEFILEHEADER), Version=1,
    FirstMovieImage=FIRST, TotalImageCount=FRAMES, FirstImageNo=FIRST, ImageCount=FRAMES,
    OffImageHeader=sizeof(CINEFILEHEADER), OffSetup=setup_at, OffImageOffsets=table_at)
bitmap = BITMAPINFOHEADER(
    biSize=sizeof(BITMAPINFOHEADER), biWidth=SIDE, biHeight=SIDE, biPlanes=1, biBitCount=16,
    biSizeImage=2 * SIDE * SIDE)
setup = SETUP(RealBPP=12, WhiteLevel=4095, Length=sizeof(SETUP))
with open('flash.cine', 'wb') as film:
    for part in (head, bitmap, setup):
        film.write(part)
    film.write(np.arange(FRAMES, dtype='<i8') * IMAGE + images_at)
    for number in range(FIRST, FIRST + FRAMES):
        film.write(np.array([8, 2 * SIDE * SIDE], '<u4'))
        film.write(np.full((SIDE, SIDE), 100 + number, '<u2'))

found = {}
for start in (FIRST, 0, 1):
    frames = read_frames('flash.cine', start_frame_cine=start, count=2)[0]
    found[start] = [int(frame[0, 0]) for frame in frames]
    print(f'from {start}:', *found[start])
if found != {FIRST: [101, 98], 0: [98, 99], 1: [100, 101]}:
    raise SystemExit('pycine no longer starts one frame too early.')
END
