"""The frames of a video, by OpenCV."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
import sys

from blob_tracker.commands.sources.source import frame_of, Source, SourceError, SourceFrame
import cv2
import numpy as np

SUFFIXES = (
    '.avi', '.h264', '.m4v', '.mjpeg', '.mjpg', '.mkv', '.mov', '.mp4', '.mpeg', '.mpg', '.mts',
    '.ts', '.webm', '.wmv',
)
# Frames that a sound file may have fewer than its header, which counts one that was never ended.
FEW = 2
# FourCC, in lower case -> name, of what loses detail.
LOSSY = {
    **dict.fromkeys(('mp4v', 'fmp4', 'm4s2', 'divx', 'dx50', 'xvid'), 'MPEG-4'),
    **dict.fromkeys(('h264', 'x264', 'avc1'), 'H.264'),
    **dict.fromkeys(('hevc', 'hev1', 'hvc1'), 'H.265'),
    **dict.fromkeys(('mpg1', 'mpg2', 'mp2v'), 'MPEG-2'),
    **dict.fromkeys(('mjpg', 'jpeg'), 'JPEG'),
    **dict.fromkeys(('vp80', 'vp90', 'vp09'), 'VP8 or VP9'),
    **dict.fromkeys(('wmv1', 'wmv2', 'wmv3', 'wvc1'), 'WMV'),
    'av01': 'AV1',
}
COUNTED = ('.avi', '.m4v', '.mov', '.mp4')  # whose header has the frames; of others it is a guess


def open_video(path: Path) -> Source:
    """Open a video; its colours are blue, green and red."""
    video = cv2.VideoCapture(str(path))
    if not video.isOpened():
        raise SourceError(
            f'{path} is not a video that OpenCV can read: copy it again if it was cut, or convert '
            'it to FFV1 (.mkv)'
        )
    code = int(video.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, 'little', signed=True)
    codec = LOSSY.get(code.decode('latin-1').lower())
    if codec:
        print(
            f'{path} is coded as {codec}, which may lose detail: sigmas are then too small, and '
            'blocks may be taken for lights; FFV1 (.mkv) or PNG keep all',
            file=sys.stderr,
        )
    count = int(video.get(cv2.CAP_PROP_FRAME_COUNT))
    whole = count if path.suffix.lower() in COUNTED else 0
    return Source(_frames(path, video, whole), count if count > 0 else None, 'the video')


def _frames(path: Path, video: cv2.VideoCapture, whole: int) -> Iterator[SourceFrame]:
    """Yield the frames; those for which there is no time go on at the pace of those before."""
    index, last, step = 0, 0.0, 0.0
    try:
        while True:
            there, pixels = video.read()
            if not there:
                if 0 < whole - index <= FEW:
                    print(
                        f'{path} has {index} frames that can be read, and {whole} by its header',
                        file=sys.stderr,
                    )
                elif index < whole:
                    raise SourceError(
                        f'{path} ends after {index} of {whole} frames: it was cut or is damaged; '
                        'copy it again'
                    )
                return
            told = video.get(cv2.CAP_PROP_POS_MSEC) / 1e3  # of the frame that was read
            seconds: float | None = told
            if index and told == 0.0:
                # OpenCV 4.14 has no time for raw streams, nor for the last frames of H.264 in AVI.
                seconds = last + step if step else None
            elif index:
                step = told - last
            if seconds is not None:
                last = seconds
            name = f'frame {index}' if seconds is None else f'{seconds:.3f} s'
            pixels = np.asarray(pixels)
            yield frame_of(
                pixels, name, None if seconds is None else round(1e9 * seconds),
                'bgr' if pixels.ndim == 3 else '',
            )
            index += 1
    finally:
        video.release()
