#!/usr/bin/env bash
# Grey video that PyAV encodes without loss as H.264 comes back clipped at both ends.
#
# Expected: 'gray' frames in a 'gray' stream of libx264 with qp 0 are read as they were written.
# Happens: the pixels are stored as they are, but nothing in the stream says that they are of full
# range; PyAV and OpenCV then stretch 16 to 235 over 0 to 255, and 36 grey levels are gone. The
# ffmpeg command marks the same stream and has no such loss; with PyAV it takes
# stream.codec_context.color_range = 2.
# Matters: a light of 240 counts as saturated, the read noise of the dark lies below 0, and
# every other brightness is off by the factor 1.16.
#
# PyAV 16.0.1 with libx264, qp 0, what 0, 16, 17, 128, 235 and 255 became:
#   as it comes: 0, 0, 1, 130, 255, 255
#   with color_range: 0, 16, 17, 128, 235, 255
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    numpy==2.2.6 av==16.0.1
cd "$folder"
"$folder/venv/bin/python" -I - <<'END'
import av
import numpy as np

RAMP = np.tile(np.arange(256, dtype=np.uint8), (64, 1))
LOOKED_AT = [0, 16, 17, 128, 235, 255]


def there_and_back(color_range: int | None) -> list[int]:
    """Return what has become of some grey levels."""
    with av.open('grey.mkv', 'w') as film:
        stream = film.add_stream('libx264', rate=60, options={'qp': '0'})
        stream.width, stream.height, stream.pix_fmt = 256, 64, 'gray'
        if color_range is not None:
            stream.codec_context.color_range = color_range
        film.mux(stream.encode(av.VideoFrame.from_ndarray(RAMP, format='gray')))
        film.mux(stream.encode())
    with av.open('grey.mkv') as film:
        frame = next(film.decode(video=0))
    return frame.to_ndarray(format='gray')[0, LOOKED_AT].tolist()


plain, marked = there_and_back(None), there_and_back(2)
print('as it comes:', *plain)
print('with color_range:', *marked)
if (plain, marked) != ([0, 0, 1, 130, 255, 255], LOOKED_AT):
    raise SystemExit('PyAV no longer leaves grey H.264 without its range.')
END
