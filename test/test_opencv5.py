"""OpenCV 5 changed array shapes: what works with the pinned 4 must work with it too."""

from __future__ import annotations

import os
from pathlib import Path
import subprocess
import sys

import pytest

HERE = Path(__file__).parent
OPENCV5 = Path(sys.prefix) / 'opencv5'  # `make test` puts it there
ROOMS = (
    'segmentation', 'simulation', 'capture/pixel_formats', 'calibration/test_board.py',
    'studies/test_track_report.py', 'studies/beyond/test_default_pipeline.py',
)


@pytest.mark.timeout(300)  # the tests of three rooms: 45 s on a quiet machine
def test_the_rooms_work_with_opencv_5() -> None:
    """The tests of all rooms that use OpenCV pass with it in front of the pinned one."""
    if not OPENCV5.is_dir():
        reason = f'no OpenCV 5 in {OPENCV5}: make test installs it'
        if os.environ.get('CI'):
            pytest.fail(reason)
        pytest.skip(reason)
    path = os.pathsep.join([str(OPENCV5), *os.environ.get('PYTHONPATH', '').split(os.pathsep)])
    environment = dict(os.environ, PYTHONPATH=path)
    version = [sys.executable, '-c', 'import cv2; print(cv2.__version__)']
    found = subprocess.run(
        version, env=environment, cwd=OPENCV5, capture_output=True, text=True, check=True
    )
    assert found.stdout.startswith('5.')
    tests = [sys.executable, '-m', 'pytest', '-q', '-p', 'no:cacheprovider']
    tests += [str(HERE / room) for room in ROOMS] + ['-k', 'not draws']
    result = subprocess.run(tests, env=environment, cwd=HERE, capture_output=True, text=True)
    assert result.returncode == 0, result.stdout[-4000:]
    assert ' passed' in result.stdout
