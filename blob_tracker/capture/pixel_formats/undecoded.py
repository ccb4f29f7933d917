"""Pixel formats that are not decoded here: what they are, and what to do instead."""

from __future__ import annotations

from collections.abc import Iterable

_VIDEO = (
    'video that is compressed over several pictures; decode it with ffmpeg or GStreamer into '
    'v4l2loopback, and read that'
)
_PISP = (
    'raw that the camera interface of a Raspberry Pi 5 has compressed; choose an unpacked '
    "format, of 16 bits, with media-ctl and v4l2-ctl (rpicam-apps: --mode with U for 'unpacked')"
)
_IPU3 = (
    "packed raw of Intel's IPU3; have libcamera turn it into another format, into v4l2loopback"
)
_ADVICE = {
    **dict.fromkeys(
        ('H264', 'AVC1', 'M264', 'S264', 'HEVC', 'S265', 'MPEG', 'MPG1', 'MPG2', 'MPG4', 'XVID',
         'H263', 'VP80', 'VP90', 'AV01', 'FWHT', 'dvsd'),
        _VIDEO,
    ),
    **{f'PC{mode}{order}': _PISP for mode in '12' for order in 'RGgBM'},
    **dict.fromkeys(('ip3b', 'ip3g', 'ip3G', 'ip3r', 'ip3y'), _IPU3),
}


def advice(names: Iterable[str]) -> str:
    """
    Return what to do about pixel formats, in words after a semicolon; '' where nothing is known.

    Parameters
    ----------
    names : iterable of str
        Four-character codes.

    """
    by_advice: dict[str, list[str]] = {}
    for name in names:
        if name in _ADVICE:
            by_advice.setdefault(_ADVICE[name], []).append(name)
    return ''.join(f'; {", ".join(named)}: {words}' for words, named in by_advice.items())
