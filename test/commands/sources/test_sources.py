"""One place opens whatever holds frames: the pixels are those that were written."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
import sys

from blob_tracker.capture import NoFrameError
from blob_tracker.colour import grey_pixels
from blob_tracker.commands.exit_code import UsageError
from blob_tracker.commands.sources import (
    add_source, grey_frames, is_folder, is_live, is_topic, open_source, SourceError,
)
from blob_tracker.types import Frame
import cv2
import numpy as np
import pytest
from support.written_sources import (
    dated_fits, EXPOSURE_S, FIRST, fits, folder, light_frames, RATE, tiff, video,
)
import tifffile

COUNT = 6
FRAMES = light_frames(COUNT)
BAG = Path(__file__).parents[2] / 'bags' / 'flash_mcap'
SIZE = f'{FRAMES[0].shape[1]}x{FRAMES[0].shape[0]}'
RAW = '--pixel-format', 'GREY', '--size', SIZE


def arguments(*words: object) -> argparse.Namespace:
    """Return what the options say."""
    parser = argparse.ArgumentParser()
    add_source(parser, 'a light')
    return parser.parse_args([str(word) for word in words])


def dump(path: Path, frames: Sequence[np.ndarray]) -> Path:
    """Write a raw dump."""
    path.write_bytes(b''.join(frame.tobytes() for frame in frames))
    return path


Writer = Callable[[Path], Path]
EVENLY = [index / RATE for index in range(COUNT)]


@pytest.mark.parametrize(('write', 'words', 'stamps', 'said'), [
    (lambda path: folder(path / 'f', FRAMES), (), None, ''),
    (lambda path: folder(path / 'f', FRAMES), ('--frame-rate', RATE), EVENLY, '--frame-rate 30'),
    (lambda path: video(path / 'v.avi', FRAMES), (), EVENLY, 'the video'),
    (lambda path: tiff(path / 's.tif', FRAMES), (), None, ''),
    (
        lambda path: tiff(path / 's.tiff', FRAMES, imagej=True, metadata={
            'axes': 'TYX', 'finterval': 1.0 / RATE,
        }), (), EVENLY, "ImageJ's header, 30 Hz",
    ),
    (
        lambda path: tiff(path / 's.ome.tif', FRAMES, ome=True, metadata={
            'axes': 'TYX', 'TimeIncrement': 1e3 / RATE, 'TimeIncrementUnit': 'ms',
        }), (), EVENLY, 'the OME header, 30 Hz',
    ),
    (
        lambda path: tiff(path / 's.ome.tif', FRAMES, ome=True, metadata={
            'axes': 'TYX', 'Plane': {'DeltaT': [0.0, 0.1, 0.2, 0.3, 0.5, 0.6]},
        }), (), [0.0, 0.1, 0.2, 0.3, 0.5, 0.6], 'DeltaT of the OME header',
    ),
    (lambda path: fits(path / 'c.fits', np.array(FRAMES)), (), None, ''),
    (lambda path: fits(path / 'c.fit.gz', np.array(FRAMES)), ('--frame-rate', RATE), EVENLY,
     '--frame-rate 30'),
    (lambda path: dated_fits(path / 'd', FRAMES), (), EVENLY, 'DATE-OBS of the FITS header'),
    (lambda path: dump(path / 'd.raw', FRAMES), RAW, None, ''),
])
def test_each_format(
    tmp_path: Path, write: Writer, words: tuple[object, ...], stamps: list[float] | None,
    said: str,
) -> None:
    """Every frame is there, with its pixels; stamps as the file or --frame-rate tells."""
    source = open_source(arguments(write(tmp_path), *words))
    assert (source.count, source.stamps) == (COUNT, said)
    found = list(grey_frames(source))
    assert len(found) == COUNT
    for (_, _, pixels, _), frame in zip(found, FRAMES):
        assert pixels.dtype == frame.dtype and (pixels == frame).all()
    seconds = [each for _, each, _, _ in found]
    assert seconds == ([None] * COUNT if stamps is None else pytest.approx(stamps, abs=1e-6))


def test_the_stamp_of_a_fits_is_the_middle_of_its_exposure(tmp_path: Path) -> None:
    """DATE-OBS is its beginning, in UTC."""
    frame = next(iter(open_source(arguments(dated_fits(tmp_path / 'd', FRAMES[:1]))).frames))
    begin = FIRST.astype(np.int64)
    assert frame.frame.stamp_ns == begin + round(0.5e9 * EXPOSURE_S)


def test_rows_and_colours_of_a_fits(tmp_path: Path) -> None:
    """ROWORDER BOTTOM-UP has the first row below; BAYERPAT tells the filters."""
    deep = FRAMES[0].astype(np.uint16) * 200  # stored with an offset, as FITS has no unsigned
    up = open_source(arguments(fits(tmp_path / 'up.fits', deep, ROWORDER='BOTTOM-UP')))
    assert (next(iter(up.frames)).frame.image == deep[::-1]).all()
    mosaic = open_source(arguments(fits(tmp_path / 'm.fits', deep, BAYERPAT='RGGB')))
    frame = next(iter(mosaic.frames)).frame
    assert frame.layout == 'rggb' and (frame.image == deep).all()


def test_pages_within_a_folder_are_frames_too(tmp_path: Path) -> None:
    """None of a TIFF of many pages is lost, whatever stands beside it."""
    path = folder(tmp_path / 'mixed', FRAMES[:1])
    tiff(path / '1.tif', FRAMES[1:])
    source = open_source(arguments(path))
    assert source.count == COUNT
    assert all(
        (each.pixels == frame).all() for each, frame in zip(grey_frames(source), FRAMES)
    )


def test_samples_of_twelve_bits_with_padded_lines(tmp_path: Path) -> None:
    """Y12P as CSI-2 packs it: two samples in three bytes, lines 16 bytes longer; 4095 clips."""
    samples = FRAMES[0].astype(np.uint16) << 4 | 5
    low = samples[:, ::2] & 15 | (samples[:, 1::2] & 15) << 4
    packed = np.dstack([samples[:, ::2] >> 4, samples[:, 1::2] >> 4, low]).astype(np.uint8)
    lines = np.pad(packed.reshape(len(samples), -1), [(0, 0), (0, 16)])
    path = dump(tmp_path / 'd.raw', [lines] * 2)
    source = open_source(arguments(
        path, '--pixel-format', 'Y12P', '--size', SIZE, '--stride', lines.shape[1]
    ))
    frames = [each.frame for each in source.frames]
    assert len(frames) == 2 and frames[1].saturation == 4095
    assert (frames[1].image == samples).all()


def test_colours_stay(tmp_path: Path) -> None:
    """A colour image is one to `track`, which chooses the channel, and luma to a calibration."""
    path = tmp_path / 'colours'
    path.mkdir()
    colours = np.dstack([FRAMES[0], FRAMES[1], FRAMES[2]])
    cv2.imwrite(str(path / '0.png'), colours)
    source = open_source(arguments(path))
    frame = next(iter(source.frames)).frame
    assert frame.layout == 'bgr' and (frame.image == colours).all()
    assert grey_pixels(frame, interpolate=True).shape == FRAMES[0].shape


def test_count_and_kind() -> None:
    """So many at most; what is live, a folder or a topic."""
    bag = arguments(BAG, '--count', 4)
    source = open_source(bag)
    assert source.count == len(list(source.frames)) == 4
    assert not (is_folder(bag) or is_live(bag) or is_topic(bag))
    assert is_folder(arguments(BAG.parent)) and is_live(arguments('camera/image_raw'))
    assert is_live(arguments('/dev/null')) and not is_topic(arguments('/dev/null'))


class PlayedCamera:
    """Stands in for a camera and its grabber: frames, then silence."""

    def __init__(self, *settings: object, **_: object) -> None:
        self.settings = settings
        self._stamps = iter((10**9, 2 * 10**9))

    def __enter__(self) -> PlayedCamera:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def newest(self, timeout: float) -> Frame:
        """Return the next frame, while there is one."""
        try:
            return Frame(FRAMES[0], next(self._stamps), 255)
        except StopIteration:
            raise NoFrameError(f'no frame for {timeout:.1f} s') from None


def test_a_camera_is_taken_until_it_is_silent(monkeypatch: pytest.MonkeyPatch) -> None:
    """With its own stamps, in the format and at the rate that are asked for."""
    opened: list[PlayedCamera] = []

    def camera(*settings: object, **options: object) -> PlayedCamera:
        opened.append(PlayedCamera(*settings, **options))
        return opened[-1]

    monkeypatch.setattr('blob_tracker.commands.sources.device.V4l2Camera', camera)
    monkeypatch.setattr('blob_tracker.commands.sources.device.Grabber', lambda camera: camera)
    source = open_source(arguments(
        '/dev/null', '--pixel-format', 'Y12', '--size', '640x480', '--frame-rate', 50
    ))
    assert opened[0].settings == ('/dev/null', 640, 480, 'Y12', 50.0)
    frames = iter(source.frames)
    found = [next(frames), next(frames)]
    assert [each.name for each in found] == ['0.000 s', '1.000 s']
    assert [each.frame.stamp_ns for each in found] == [10**9, 2 * 10**9]
    with pytest.raises(SourceError, match='no frame for 10.0 s'):
        next(frames)


def test_a_device_that_is_not_there_is_no_topic() -> None:
    """The sentence is that of the camera node."""
    with pytest.raises(SourceError, match='/dev/video987: there is no such device'):
        open_source(arguments('/dev/video987'))


@pytest.mark.parametrize(('name', 'words', 'sentence'), [
    ('v.ser', (), 'SER is not read; export it from Siril'),
    ('v.png', (), 'is one image; give the folder that holds the images'),
    ('v.xyz', (), 'a file of an unknown kind; give a folder of images'),
    ('v.tif', (), 'v.tif is not a TIFF that can be read'),
    ('v.fits', (), 'v.fits is not a FITS file that astropy can read'),
    ('v.mp4', (), 'v.mp4 is not a video that OpenCV can read'),
    ('v.raw', RAW, f'has 8 bytes and a picture of {SIZE.replace("x", " x ")} px in GREY takes'),
    ('v.raw', RAW[:2], 'does not say how large its pictures are: give --size'),
    ('v.raw', ('--pixel-format', 'MJPG', *RAW[2:]), '--pixel-format MJPG is none of a raw dump'),
])
def test_what_cannot_be_read(
    tmp_path: Path, name: str, words: tuple[str, ...], sentence: str
) -> None:
    """Is named, with what to do."""
    path = tmp_path / name
    path.write_bytes(b'no frame')
    with pytest.raises(SourceError, match=sentence.replace('(', r'\(')):
        open_source(arguments(path, *words))


def test_what_is_no_succession_of_frames(tmp_path: Path) -> None:
    """Floats, channels beside time, and pages of several sizes are named, not cut."""
    floats = tiff(tmp_path / 'f.tif', [FRAMES[0].astype(np.float32)] * 2)
    with pytest.raises(SourceError, match='holds float32; it must be 8 or 16 bits'):
        list(open_source(arguments(floats)).frames)
    channels = tiff(
        tmp_path / 'c.tif', [np.array(FRAMES[k:k + 2]) for k in (0, 2, 4)], imagej=True,
        metadata={'axes': 'TCYX'},
    )
    with pytest.raises(SourceError, match='the axes T 3, C 2'):
        open_source(arguments(channels))
    with tifffile.TiffWriter(tmp_path / 's.tif') as writer:
        for frame in (FRAMES[0], FRAMES[0][:50]):
            writer.write(frame)
    with pytest.raises(SourceError, match='holds 2 series of pictures'):
        open_source(arguments(tmp_path / 's.tif'))


def test_a_library_that_is_missing_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the command that installs it."""
    path = tiff(tmp_path / 's.tif', FRAMES)
    monkeypatch.setitem(sys.modules, 'tifffile', None)
    with pytest.raises(SourceError, match='python3 -m pip install tifffile'):
        open_source(arguments(path))


@pytest.mark.parametrize(('name', 'words', 'sentence'), [
    ('v.mp4', ('--pixel-format', 'GREY'), '--pixel-format is for a camera or a raw dump'),
    ('v.avi', ('--size', SIZE), '--size is for a camera or a raw dump'),
    ('v.tif', ('--stride', 80), '--stride is for a raw dump'),
    ('v.avi', ('--seconds', 3), '--seconds is for a camera or a topic'),
    ('v.avi', ('--topic', 'images'), '--topic is for a bag'),
])
def test_an_option_that_is_not_used_is_said(
    tmp_path: Path, name: str, words: tuple[object, ...], sentence: str
) -> None:
    """Whoever gives it expects other frames."""
    path = tmp_path / name
    path.write_bytes(b'no frame')
    with pytest.raises(UsageError, match=f'{sentence}, and .* is none: leave it out'):
        open_source(arguments(path, *words))


@pytest.mark.parametrize('name', ['nofile.mp4', 'folder/no.avi', './images', '../video', 'a b'])
def test_the_name_of_a_file_is_none_of_a_topic(name: str) -> None:
    """A calibration would wait for it for ever."""
    assert not is_topic(arguments(name))
    with pytest.raises(UsageError, match='there is no file'):
        open_source(arguments(name))
    for topic in ('images', '/camera/image_raw', '~/debug_image'):
        assert is_topic(arguments(topic))
