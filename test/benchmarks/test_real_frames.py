"""The segmenter on frames of real cameras: a laser line switched on and off, and stars."""

import os
from pathlib import Path

from benchmarks import real_frames
import pytest

DATA = os.environ.get('BLOB_TRACKER_DATA', '')
pytestmark = pytest.mark.skipif(
    not Path(DATA, 'stars').is_dir() or not Path(DATA, 'laser_on_off').is_dir(),
    reason='BLOB_TRACKER_DATA does not name a folder with stars/ and laser_on_off/',
)


@pytest.fixture(scope='module')
def rows():
    """Return what was found in each pair and frame."""
    return real_frames.run(Path(DATA))


def test_line_is_found_by_its_colour():
    """Find a line across most of each picture, and in no more than a tenth of its pixels."""
    for path in sorted((Path(DATA) / 'laser_on_off').glob('*-b-*.jpg')):
        truth = real_frames.line(*real_frames.pair(path))
        assert truth.any(axis=0).mean() > 0.5, path.stem
        assert truth.mean() < 0.1, path.stem


def test_difference_picks_the_laser_line(rows):
    """Have what rose most on the line in each pair, also where the exposure jumped."""
    laser = [row for row in rows if row.kind == real_frames.LASER]
    assert laser
    for row in laser:
        assert row.found == 1, row.name


def test_no_window_off_the_line(rows):
    """Give no window for anything else, and say why."""
    for row in rows:
        if row.kind == real_frames.LASER:
            assert row.windows == 0, row.name
            assert row.reason, row.name


def test_exposure_jump_is_said(rows):
    """Say that the exposure jumped in the first pair, 2.5 times, and in no other."""
    laser = [row for row in rows if row.kind == real_frames.LASER]
    assert ['auto-exposure' in row.reason for row in laser] == [True] + [False] * (len(laser) - 1)


def test_stars_above_peak_snr_8(rows):
    """Find them, and take one light for the target in each frame."""
    stars = [row for row in rows if row.kind == real_frames.STARS]
    assert stars
    # Where a star is in the middle of a pixel and its image is sharp, noise may leave no more in
    # the neighbours than about a hot pixel: of SNR 10 that is one star in a hundred.
    assert sum(row.found for row in stars) >= 0.99 * sum(row.total for row in stars)
    assert all(row.windows == 1 for row in stars)


def test_missed_stars_are_lone_pixels():
    """Miss a star for no other reason than that its light is in one pixel."""
    for name, x, y, instead in real_frames.missed(Path(DATA)):
        assert instead is not None and 'lone pixel' in instead.rejected, (name, x, y)
