#!/usr/bin/env bash
# Matroska and WebM round time stamps to milliseconds, whatever time base they are given.
#
# Expected: stamps in microseconds, in a stream whose time base is set to one microsecond, are kept
# as they are, as MP4 and NUT do.
# Happens: the muxer puts its own time base of 1 ms in place of the one that was set, and rounds.
# Nothing is said; the stream's time_base has changed once the first packet is written.
# Matters: 0.5 ms is 0.25 px for a light that moves by 8 px a frame at 60 Hz, and the jitter of a
# camera cannot be told from that of the file.
#
# PyAV 16.0.1, stamps of 0, 16683, 33371 and 50049 us:
#   mkv: 0, 17000, 33000, 50000
#   webm: 0, 17000, 33000, 50000
#   mp4: 0, 16683, 33371, 50049
#   nut: 0, 16683, 33371, 50049
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 av==16.0.1
cd "$folder"
"$folder/venv/bin/python" -I - <<'END'
from fractions import Fraction

import av
import numpy as np

STAMPS = [0, 16_683, 33_371, 50_049]  # us
MICROSECOND = Fraction(1, 1_000_000)


def kept(kind: str, codec: str) -> list[int]:
    """Return the stamps as they are read from a file of this kind, in us."""
    with av.open(f'film.{kind}', 'w') as film:
        stream = film.add_stream(codec, rate=60)
        stream.width, stream.height, stream.pix_fmt = 64, 64, 'yuv420p'
        stream.time_base = stream.codec_context.time_base = MICROSECOND
        for stamp in STAMPS:
            frame = av.VideoFrame.from_ndarray(np.zeros((96, 64), np.uint8), format='yuv420p')
            frame.pts, frame.time_base = stamp, MICROSECOND
            film.mux(stream.encode(frame))
        film.mux(stream.encode())
    with av.open(f'film.{kind}') as film:
        return [round(frame.time * 1e6) for frame in film.decode(video=0)]


ROUNDED = [0, 17_000, 33_000, 50_000]
as_described = True
for kind, codec, expected in (('mkv', 'ffv1', ROUNDED), ('webm', 'libvpx-vp9', ROUNDED),
                              ('mp4', 'libx264', STAMPS), ('nut', 'ffv1', STAMPS)):
    found = kept(kind, codec)
    print(f'{kind}:', *found)
    as_described &= found == expected

if not as_described:
    raise SystemExit('The containers no longer round as described.')
END
